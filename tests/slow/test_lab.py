"""JupyterLab as `make lab` starts it: the kernel that it has is the repository's."""

import json
import os
import socket
import subprocess
import time
import urllib.request

import pytest
import test_contributing

clone = test_contributing.clone


@pytest.fixture
def lab(clone, tmp_path):
    """Start JupyterLab as `make lab` does, without a browser; stop it afterwards."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    options = f"--no-browser --port={port} --IdentityProvider.token=t --allow-root"
    other = tmp_path / "other" / "kernels" / "python3"  # as a user may have
    other.mkdir(parents=True)
    spec = {"argv": ["false"], "display_name": "Another", "language": "python"}
    (other / "kernel.json").write_text(json.dumps(spec), "utf-8")
    mine = os.environ | {"HOME": str(tmp_path), "JUPYTER_PATH": str(tmp_path / "other")}
    server = subprocess.Popen(
        ["make", "lab", f"LAB={options}"],
        cwd=clone,
        env=mine,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )

    def ask(address):
        url = f"http://127.0.0.1:{port}/api/{address}?token=t"
        with urllib.request.urlopen(url, timeout=60) as answer:
            return json.load(answer)

    for _ in range(240):
        try:
            ask("status")
            break
        except OSError:
            assert server.poll() is None, "JupyterLab has ended"
            time.sleep(0.5)
    yield ask
    os.killpg(server.pid, 2)
    server.wait(timeout=60)


def test_lab_opens_the_repository_with_its_own_kernel(lab, clone):
    names = {item["name"] for item in lab("contents")["content"]}
    assert {"book", "Makefile", "pyproject.toml"} <= names
    assert "no" not in names
    found = lab("kernelspecs")
    program = found["kernelspecs"][found["default"]]["spec"]["argv"][0]
    assert program in ("python", str(clone / ".venv" / "bin" / "python"))
