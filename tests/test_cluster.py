"""The search on a Dask cluster: scheduler and workers are processes on loopback."""

import importlib
import json
import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import msc._parallel
import msc.search._sweep
from msc.cli import main
from msc.search._journal import Journal

SEARCH = ["search", "--workspace", "obstacles", "--tasks", "4", "--jobs", "1"]
SEARCH += ["--set", "max_evaluations=9", "--set", "max_sweeps=1"]
SEARCH += ["--set", "agreement=2"]  # all of a generation at once
N_WORKERS = 2
README = Path(__file__).parents[1] / "README.md"

# What a worker loads before it starts, so that it has no msc until there is a file.
WITHOUT = """
import sys
from pathlib import Path

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "msc" and not Path("msc is there").exists():
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
"""


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@contextmanager
def process(folder, program, *arguments):
    """Run a program of Dask's in the background, its messages in a file."""
    package = str(Path(msc.search._sweep.__file__).parents[2])
    environment = {"PYTHONPATH": package, "OMP_NUM_THREADS": "1"}
    with (folder / f"{program}.log").open("a", encoding="utf-8") as log:
        running = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *arguments],
            cwd=folder,
            env={**os.environ, **environment},
            stdout=log,
            stderr=log,
        )
    try:
        yield running
    finally:
        running.kill()
        running.wait()


@contextmanager
def scheduler(folder):
    """Start a scheduler at a free port and return its address."""
    pytest.importorskip("distributed", reason="needs the extra msc[cluster]")
    file = folder / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)]
    options += ["--dashboard-address", "127.0.0.1:0", "--no-dashboard", "--no-jupyter"]
    with process(folder, "dask_scheduler", *options) as running:
        while not (file.is_file() and file.read_text("utf-8").endswith("}")):
            assert running.poll() is None, (folder / "dask_scheduler.log").read_text(
                "utf-8"
            )
            time.sleep(0.05)
        yield json.loads(file.read_text("utf-8"))["address"]


def worker(folder, address, preload=""):
    """Start a worker of one thread."""
    file = folder / "preload.py"
    file.write_text(preload, "utf-8")
    options = ["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    options += ["--preload", str(file), "--local-directory", str(folder)]
    options += ["--death-timeout", "60"]
    return process(folder, "dask_worker", address, *options)


def wait_for_workers(address, n_workers):
    from distributed import Client  # noqa: PLC0415

    with Client(address) as client:
        client.wait_for_workers(n_workers, timeout=120)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    assert main([*SEARCH, "--out", str(folder / "table.csv")]) == 0
    return contents(folder)


def contents(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.fixture
def complaint(capfd):
    """What `msc search --dask` says when it fails, and how long it takes."""

    def ask(address):
        begun = time.monotonic()
        assert main([*SEARCH, "--dask", address, "--out", "table.csv"]) == 2
        told = capfd.readouterr().err.splitlines()
        (line,) = [one for one in told if one.startswith("msc: error: ")]
        assert not list(Path().iterdir())
        return line, time.monotonic() - begun

    return ask


# The same bytes


def test_a_cluster_finds_what_one_process_finds_though_a_worker_is_killed(
    tmp_path_factory, whole, here, monkeypatch, complaint
):
    """To begin with there is no worker at all, then one that lacks msc."""
    folder = tmp_path_factory.mktemp("cluster")
    append, n_done = Journal.append, []

    def append_and_kill(*entry):
        append(*entry)
        first.kill()
        n_done.append(entry)

    with scheduler(folder) as address, ExitStack() as stack:
        assert f"{address} has no workers" in complaint(address)[0]
        with worker(folder, address, WITHOUT) as first:
            wait_for_workers(address, 1)
            assert "No module named 'msc" in complaint(address)[0]
            (folder / "msc is there").touch()
            stack.enter_context(worker(folder, address))
            wait_for_workers(address, N_WORKERS)
            monkeypatch.setattr(msc.search._sweep, "search_steps", None)  # not here
            monkeypatch.setattr(Journal, "append", append_and_kill)
            assert main([*SEARCH, "--dask", address, "--out", "new/table.csv"]) == 0
            assert first.wait() == -9
    assert contents(here / "new") == whole
    assert len(n_done) == len({entry[1:3] for entry in n_done})


def test_a_scheduler_that_is_gone_is_told_of(whole, here, monkeypatch, capfd):
    distributed = pytest.importorskip("distributed")
    options = {"dashboard_address": "127.0.0.1:0", "local_directory": here / "local"}
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", **options
    ) as cluster:
        address, append = cluster.scheduler_address, Journal.append

        def append_and_close(*entry):
            append(*entry)
            cluster.close()

        with monkeypatch.context() as patch:
            patch.setattr(Journal, "append", append_and_close)
            assert main([*SEARCH, "--dask", address, "--out", "new/table.csv"]) == 2
    assert capfd.readouterr().err.endswith(
        f"msc: error: dask: the connection to the scheduler {address} was lost; the "
        "same command goes on from here\n"
    )
    assert main([*SEARCH, "--out", "new/table.csv"]) == 0
    assert contents(here / "new") == whole


@pytest.fixture
def certificate(tmp_path_factory):
    """Make a certificate by the README's own command; return Dask's settings."""
    pytest.importorskip("distributed")
    if shutil.which("openssl") is None:
        pytest.skip("needs openssl")
    folder = tmp_path_factory.mktemp("certificate")
    command = re.findall("^openssl .*", README.read_text(encoding="utf-8"), re.M)[0]
    subprocess.run(shlex.split(command), cwd=folder, check=True, capture_output=True)
    files = {"cert": str(folder / "cert.pem"), "key": str(folder / "key.pem")}
    each = {
        f"{who}.{what}": file
        for who in ("client", "scheduler", "worker")
        for what, file in files.items()
    }
    return tls(**each | {"ca-file": files["cert"]})


def tls(**settings):
    """Name settings of Dask's as it does, once it has read its own."""
    importlib.import_module("distributed")
    return {f"distributed.comm.tls.{name}": value for name, value in settings.items()}


def test_by_tls_a_worker_of_several_threads_finds_the_same(certificate, whole, here):
    import dask  # noqa: PLC0415
    import distributed  # noqa: PLC0415

    with (
        dask.config.set(certificate),
        distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=2,
            processes=False,
            protocol="tls",
            security=distributed.Security(require_encryption=True),
            dashboard_address="127.0.0.1:0",
            local_directory=here / "local",
        ) as cluster,
    ):
        address = cluster.scheduler_address
        assert address.startswith("tls://")
        assert main([*SEARCH, "--dask", address, "--out", "new/table.csv"]) == 0
    assert contents(here / "new") == whole


# Bad input


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({}, "tls://127.0.0.1:1 wants TLS, but distributed.comm.tls.ca-file is not"),
        ({"ca-file": __file__}, "wants TLS, but distributed.comm.tls.client.cert is"),
        ({"ca-file": "nowhere"}, "tls.ca-file is 'nowhere', but there is no such file"),
    ],
)
def test_without_a_certificate_tls_is_refused(settings, said, capsys):
    pytest.importorskip("distributed")
    from dask import config  # noqa: PLC0415

    with config.set(tls(**settings)):
        arguments = ["--dask", "tls://127.0.0.1:1", "--out", "table.csv"]
        assert main([*SEARCH, *arguments]) == 2
    assert said in capsys.readouterr().err


def test_where_no_scheduler_listens_the_address_is_named_soon(complaint, monkeypatch):
    pytest.importorskip("distributed")
    assert msc._parallel.ANSWER_SECONDS <= 10
    monkeypatch.setattr(msc._parallel, "ANSWER_SECONDS", 1)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))  # and does not listen
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        line, seconds = complaint(address)
    assert line.startswith(f"msc: error: dask='{address}': ")
    assert f"trying to connect to {address}" in line
    assert seconds < 11


@pytest.mark.parametrize("address", ["foo", "foo://bar:1"])
def test_what_is_no_address_is_named(address, complaint):
    pytest.importorskip("distributed")
    line = complaint(address)[0]
    assert line.startswith(f"msc: error: dask='{address}': ")
    assert line.endswith("; wanted a scheduler's tcp://host:port, or tls://")


def test_without_the_extra_it_is_asked_for(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    arguments = [*SEARCH, "--dask", "tcp://127.0.0.1:1", "--out", "table.csv"]
    assert main(arguments) == 2
    assert "wanted the extra, pip install 'msc[cluster]'" in capsys.readouterr().err
    assert not list(Path().iterdir())
