"""One process, many threads: whatever they share, each finds what it finds alone."""

import copy
import gc
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
import warnings
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from joblib import Parallel, delayed, parallel_config

import msc.study._measure
from msc import Arm, Workspace, search_policy
from msc.robot import Physics, cached_arm
from msc.robot._bullet import load_pybullet
from msc.search import SearchOptions, record_search
from msc.study import execute_policies

N_THREADS = 8

bullet = load_pybullet()
free, walled = Workspace.free(), Workspace.obstacles()
rng = np.random.default_rng(0)
policies = 4 * rng.normal(size=(18, 6))
tasks = rng.uniform(0, 360, size=18)


@pytest.fixture(scope="module")
def alone():
    """What the policies do when nothing else happens."""
    with Arm(walled) as arm:
        return bits(arm.execute_many(policies, tasks))


@pytest.fixture
def arm():
    with Arm(walled) as arm:
        yield arm


@pytest.fixture
def other_engine():
    reason = "MuJoCo, the second engine, is not installed: pip install msc[mujoco]"
    pytest.importorskip("mujoco", reason=reason)
    return replace(walled, physics=Physics(engine="mujoco"))


def bits(rollouts):
    return [
        [np.asarray(value).tobytes() for value in astuple(rollout)]
        for rollout in rollouts
    ]


def in_threads(function, arguments=range(N_THREADS)):
    """Call a function in threads that change places often; return what it returned."""
    arguments = list(arguments)
    together = threading.Barrier(len(arguments))

    def call(argument):
        together.wait()
        return function(argument)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    try:
        with ThreadPoolExecutor(len(arguments)) as pool:
            return list(pool.map(call, arguments))
    finally:
        sys.setswitchinterval(before)


def executed(arm, seed):
    """Execute all policies in an order of one's own; return them in the first."""
    order = np.random.default_rng(seed).permutation(len(tasks))
    found = arm.execute_many(policies[order], tasks[order])
    return bits(found[k] for k in np.argsort(order))


# To the last bit


def test_threads_that_share_an_arm(arm, alone):
    for found in in_threads(lambda seed: executed(arm, seed)):
        assert found == alone


def test_threads_that_each_have_an_arm(alone):
    for found in in_threads(lambda seed: executed(cached_arm(walled), seed)):
        assert found == alone


def test_joblib_s_threads(alone):
    table = pd.DataFrame({"task_deg": tasks, "cost": 0.0})
    wanted = execute_policies(walled, policies, table)
    msc.study._measure._DONE.clear()  # executed again, by whoever comes first
    with parallel_config("threading", n_jobs=4):
        found = Parallel()(
            delayed(execute_policies)(walled, policies, table) for _ in range(4)
        )
    for one in found:
        pd.testing.assert_frame_equal(one, wanted, check_exact=True)


brief = SearchOptions(max_evaluations=9)


def searched(task):
    result = search_policy(walled, task, seed=0, n_starts=1, options=brief)
    *numbers, runs, _ = astuple(result)
    return [np.asarray(value).tobytes() for value in numbers], repr(runs)


def test_searches_in_threads():
    wanted = [searched(task) for task in tasks[:4]]
    assert in_threads(searched, tasks[:4]) == wanted


def test_recorded_searches_in_threads():
    def costs(task):
        [run] = record_search(walled, task, seed=0, n_starts=1, options=brief)
        return run.costs.tobytes(), run.joints.tobytes()

    assert in_threads(costs, tasks[:2]) == [costs(task) for task in tasks[:2]]


# Closed, entered again, interrupted


def test_an_arm_closed_by_another_thread_says_so(arm, alone):
    begun = threading.Event()
    complete = []

    def execute():
        while True:
            complete.append(bits(arm.execute_many(policies, tasks)))
            begun.set()

    with ThreadPoolExecutor(1) as pool:
        working = pool.submit(execute)
        assert begun.wait(30)
        arm.close()
        with pytest.raises(RuntimeError, match="the arm is closed; wanted an open one"):
            working.result(timeout=30)
    assert all(found == alone for found in complete)


@pytest.mark.parametrize("call", ["execute", "close"])
def test_a_call_from_within_a_rollout_is_refused(call, arm, alone, monkeypatch):
    def handler():
        with pytest.raises(RuntimeError, match="the arm is in the middle of a rollout"):
            arm.close() if call == "close" else arm.execute(policies[0], 0)
        return read()

    read = arm._world._read
    monkeypatch.setattr(arm._world, "_read", handler)
    assert bits(arm.execute_many(policies, tasks)) == alone


class Interrupted:
    """PyBullet, but for Ctrl-C in place of one call."""

    def __init__(self, n):
        self._left = n

    def __getattr__(self, name):
        found = getattr(bullet, name)
        return found if name == "error" or not callable(found) else self._counted(found)

    def _counted(self, function):
        def call(*arguments, **options):
            self._left -= 1
            if self._left == -1:
                raise KeyboardInterrupt
            return function(*arguments, **options)

        return call


@pytest.mark.parametrize("n", [0, 1, 40, *range(45, 75, 4), 333, 600, 700, 1111, 1180])
def test_after_an_interrupt_the_next_rollout_is_right(n, arm, alone, monkeypatch):
    monkeypatch.setattr(arm._world, "_bullet", Interrupted(n))
    with pytest.raises(KeyboardInterrupt):
        arm.execute_many(policies, tasks)
    monkeypatch.undo()
    assert bits(arm.execute_many(policies[:9], tasks[:9])) == alone[:9]
    assert bits(in_threads(lambda _: arm.execute(policies[0], tasks[0]), [0])) == [
        alone[0]
    ]


# All of it in MuJoCo


class Entered:
    """MuJoCo, but for a call in the place of its hundredth step."""

    def __init__(self, mujoco, call):
        self._mujoco, self._call, self._left = mujoco, call, 100

    def __getattr__(self, name):
        return getattr(self._mujoco, name)

    def mj_step(self, *state):
        self._left -= 1
        if self._left == 0:
            self._call()
        self._mujoco.mj_step(*state)


def interrupt():
    raise KeyboardInterrupt


def test_threads_share_an_arm_in_mujoco_and_a_closed_one_says_so(other_engine):
    with Arm(other_engine) as arm:
        wanted = bits(arm.execute_many(policies, tasks))
        for found in in_threads(lambda seed: executed(arm, seed), range(4)):
            assert found == wanted
        begun, complete = threading.Event(), []

        def execute():
            while True:
                complete.append(bits(arm.execute_many(policies, tasks)))
                begun.set()

        with ThreadPoolExecutor(1) as pool:
            working = pool.submit(execute)
            assert begun.wait(30)
            arm.close()
            with pytest.raises(RuntimeError, match="the arm is closed; wanted an open"):
                working.result(timeout=30)
        assert all(found == wanted for found in complete)
        assert arm.client_id == -1
        assert not arm._world._states


@pytest.mark.parametrize("call", ["execute", "close"])
def test_a_call_from_within_a_rollout_in_mujoco_is_refused(call, other_engine):
    def enter():
        with pytest.raises(RuntimeError, match="the arm is in the middle of a rollout"):
            arm.close() if call == "close" else arm.execute(policies[0], 0)

    with Arm(other_engine) as arm:
        wanted = bits(arm.execute_many(policies, tasks))
        arm._world._mujoco = Entered(arm._world._mujoco, enter)
        assert bits(arm.execute_many(policies, tasks)) == wanted
        arm._world._mujoco._call, arm._world._mujoco._left = interrupt, 100
        with pytest.raises(KeyboardInterrupt):
            arm.execute_many(policies[::-1], tasks[::-1])
        assert bits(arm.execute_many(policies, tasks)) == wanted


def test_a_forked_process_has_a_copy_in_mujoco_and_none_is_pickled(other_engine):
    def in_child(send):
        send.send(bits(arm.execute_many(policies, tasks)) == wanted)

    over = threading.Event()

    def busy():
        while not over.is_set():
            arm.execute_many(policies[::-1], tasks[::-1])

    with Arm(other_engine) as arm, ThreadPoolExecutor(1) as pool:
        with pytest.raises(TypeError, match="an Arm cannot be copied or pickled"):
            pickle.dumps(arm)
        wanted = bits(arm.execute_many(policies, tasks))
        working = pool.submit(busy)
        receive, send = multiprocessing.Pipe(duplex=False)
        child = multiprocessing.get_context("fork").Process(
            target=in_child, args=(send,)
        )
        child.start()
        try:
            assert receive.poll(30), "the copy waits for a lock that nobody holds"
            assert receive.recv()
        finally:
            over.set()
            child.kill()
            child.join()
        working.result(timeout=30)


# Beside others in the process


def test_another_connection_changes_nothing(arm, alone):
    other = bullet.connect(bullet.DIRECT)
    try:
        for threshold in (0.5, 1e-4):
            bullet.setPhysicsEngineParameter(
                contactBreakingThreshold=threshold, physicsClientId=other
            )
            assert bits(arm.execute_many(policies, tasks)) == alone
    finally:
        bullet.setPhysicsEngineParameter(
            contactBreakingThreshold=0.02, physicsClientId=other
        )
        bullet.disconnect(other)


def test_an_arm_too_many_is_refused(monkeypatch):
    monkeypatch.setattr(bullet, "connect", lambda _: -1)
    with pytest.raises(RuntimeError, match="no more than 1024 worlds in a process"):
        Arm(free)


def test_what_cannot_be_copied_says_so(arm):
    for copied in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="an Arm cannot be copied or pickled"):
            copied(arm)


def test_a_forked_process_has_a_copy_whatever_threads_were_at(arm, alone):
    def busy(_):
        while not over.is_set():
            arm.execute_many(policies[::-1], tasks[::-1])

    def in_child(send):
        found = [bits(one.execute_many(policies, tasks)) for one in (arm, mine)]
        send.send(found == [alone, alone])

    over, mine = threading.Event(), cached_arm(walled)
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda _: None, range(2)))
        working = [pool.submit(busy, _) for _ in range(2)]
        for _ in range(3):
            receive, send = multiprocessing.Pipe(duplex=False)
            child = multiprocessing.get_context("fork").Process(
                target=in_child, args=(send,)
            )
            child.start()
            try:
                assert receive.poll(30), "the copy waits for a lock that nobody holds"
                assert receive.recv()
            finally:
                over.set()
                child.kill()
                child.join()
            over.clear()
        over.set()
        for one in working:
            one.result(timeout=30)
    assert bits(mine.execute_many(policies, tasks)) == alone


PRINTER = """
import os, sys, threading
from msc.robot._bullet import load_pybullet

def printing():
    while not over.is_set():
        for stream in (1, 2):
            lines[stream] += os.write(stream, b"x")

sys.setswitchinterval(1e-6)
over, lines = threading.Event(), {1: 0, 2: 0}
thread = threading.Thread(target=printing)
thread.start()
others = [threading.Thread(target=load_pybullet) for _ in range(4)]
for other in others:
    other.start()
for other in others:
    other.join()
over.set()
thread.join()
print(lines[1], lines[2])
"""


def test_importing_swallows_pybullet_s_line_and_no_other():
    run = subprocess.run(
        [sys.executable, "-c", PRINTER], capture_output=True, text=True, check=True
    )
    printed, counted = run.stdout.rsplit("x", 1)
    assert [len(printed) + 1, len(run.stderr)] == [int(n) for n in counted.split()]
    assert not run.stderr.strip("x")


# What is not needed any more


def resident_mb():
    pages = int(Path("/proc/self/statm").read_text("utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_forgotten_arms_are_freed_with_a_warning():
    Arm(free, n_parallel=1).close()
    before = resident_mb()
    for _ in range(12):  # some 30 MB each
        with pytest.warns(ResourceWarning, match=r"an arm .*'free'.* was not closed"):
            Arm(free, n_parallel=1)
    assert resident_mb() - before < 100


def test_an_arm_in_a_cycle_and_one_whose_warning_is_an_error_are_freed(capsys):
    before = resident_mb()
    for _ in range(4):
        arm = Arm(free, n_parallel=1)
        arm.itself = arm
    del arm
    with pytest.warns(ResourceWarning) as warned:
        gc.collect()
    assert len(warned) == 4
    hook, raised = sys.unraisablehook, []
    sys.unraisablehook = lambda seen: raised.append(seen.exc_type)
    try:
        for _ in range(4):
            Arm(free, n_parallel=1)
    finally:
        sys.unraisablehook = hook
    assert raised == [ResourceWarning] * 4
    assert resident_mb() - before < 100


def test_an_arm_that_could_not_be_built_is_freed(monkeypatch):
    before = resident_mb()
    for _ in range(6):
        monkeypatch.setattr("msc.robot._bullet.load_pybullet", lambda: Interrupted(20))
        with pytest.raises(KeyboardInterrupt):
            Arm(free)
    gc.collect()
    assert resident_mb() - before < 100


def test_kept_arms_are_one_a_thread_and_go_with_it_in_silence():
    def keep(_):
        arm = cached_arm(free)
        assert cached_arm(free) is arm
        return weakref.ref(arm), arm.client_id

    mine = cached_arm(free)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = in_threads(keep, range(3))
        gc.collect()
    assert len({client for _, client in found} | {mine.client_id}) == 4
    assert [kept() for kept, _ in found] == [None] * 3
    assert cached_arm(free) is mine


def test_a_thread_keeps_six_arms_and_none_is_freed_while_it_is_used():
    def keep(_):
        worlds = [Workspace(cut_deg=float(cut)) for cut in range(7)]
        first = cached_arm(worlds[0])
        kept = [weakref.ref(cached_arm(world)) for world in worlds]
        first.execute(policies[0], 0)
        del first
        return [arm() is not None for arm in kept]

    assert in_threads(keep, [0]) == [[False] + 6 * [True]]


AT_EXIT = """
import threading
from msc import Arm, Workspace
from msc.robot._arm import cached_arm

arm, kept = Arm(Workspace.free(), n_parallel=1), cached_arm(Workspace.free())
arm.itself = arm
"""


def test_at_exit_nothing_is_said():
    run = subprocess.run(
        [sys.executable, "-X", "dev", "-W", "error::ResourceWarning", "-c", AT_EXIT],
        capture_output=True,
        text=True,
        check=True,
    )
    assert (run.stdout, run.stderr) == ("", "")
