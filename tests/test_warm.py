"""A Python that serves copies of itself: each is as a Python of its own would be."""

import os
import signal
import subprocess
import sys
import time

import pytest

from press._processes import _WARM

SCRIPT = """
import json, os, sys
there = "colorsys" in sys.modules
told = sys.argv[1:], os.getcwd(), os.environ.get("TOLD"), sys.stdin.read(), there
print(json.dumps([os.path.basename(sys.argv[0]), *told, __name__]))
print("words", file=sys.stderr)
sys.exit(3)
"""
WAITING = "import time\nprint('here', flush=True)\ntime.sleep(600)\n"
NUMBER = "import os\nprint(os.getpid(), flush=True)\n"

pytestmark = pytest.mark.skipif(
    not hasattr(os, "pidfd_open"), reason="only Linux has pidfds"
)


@pytest.fixture
def server(tmp_path):
    command = [
        sys.executable,
        _WARM,
        "serve",
        tmp_path / "socket",
        "colorsys",
        "no_one",
    ]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"ready\n"
        yield process
        process.stdin.close()


@pytest.fixture
def ask(server, tmp_path):
    """Give a function that asks for a script, as far as Popen knows."""

    def start(text, *words, **told):
        script = tmp_path / "script.py"
        script.write_text(text, "utf-8")
        command = [sys.executable, "-IS", _WARM, "ask", tmp_path / "socket", script]
        pipe = subprocess.PIPE
        told = {"stdin": pipe, "stdout": pipe, "stderr": pipe, "text": True} | told
        return subprocess.Popen([*command, *words], **told)

    return start


def test_a_script_finds_all_as_in_a_python_of_its_own(ask, tmp_path):
    with ask(SCRIPT, "a", "b c", cwd=tmp_path, env={"TOLD": "é"}) as asker:
        out, said = asker.communicate("given")
    assert asker.returncode == 3
    assert said == "words\n"
    told = '["script.py", ["a", "b c"], "%s", "\\u00e9", "given", true, "__main__"]\n'
    assert out == told % tmp_path


def test_an_error_is_told_and_fails(ask):
    with ask("1 / 0") as asker:
        _, said = asker.communicate()
    assert asker.returncode == 1
    assert said.endswith("ZeroDivisionError: division by zero\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_reaches_the_script(ask, number):
    with ask(WAITING) as asker:
        assert asker.stdout.readline() == "here\n"
        asker.send_signal(number)
        _, said = asker.communicate()
    assert asker.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[number]
    assert ("KeyboardInterrupt" in said) == (number == signal.SIGINT)


@pytest.mark.parametrize("end", ["asker", "server"])
def test_a_script_ends_with_who_asked_and_with_who_serves(ask, server, end):
    with ask(NUMBER + WAITING) as asker:
        copy = int(asker.stdout.readline())
        if end == "asker":
            asker.kill()
        else:
            server.stdin.close()
            assert server.wait() == 0
        for _ in range(200):
            if is_gone(copy):
                break
            time.sleep(0.05)
        assert is_gone(copy)


def is_gone(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    return False
