"""`frictionlab app`: what it serves, what it refuses, and how it ends."""

import contextlib
import gc
import importlib.util
import os
import re
import signal
import socket
import subprocess
import sys
import time
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

import pytest

from frictionlab.cli import app, command


@pytest.mark.slow
def test_a_port_in_use_is_refused(refused):
    pytest.importorskip("voila", reason="voila serves the page; it is not installed")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        err = refused("app", "--port", str(port))
    assert f"--port {port} cannot be had" in err
    assert "give another, or leave it out" in err


@pytest.mark.slow
# Tornado leaves the socket to the garbage collector that could not have the port.
@pytest.mark.filterwarnings("ignore:unclosed:ResourceWarning")
def test_without_a_port_another_is_taken_where_the_usual_one_is_in_use(monkeypatch):
    pytest.importorskip("voila", reason="voila serves the page; it is not installed")
    with contextlib.ExitStack() as opened:
        taken = opened.enter_context(socket.create_server(("127.0.0.1", 0)))
        monkeypatch.setattr(app, "DEFAULT_PORT", taken.getsockname()[1])
        first, second = (
            [opened.enter_context(each) for each in app.listening_sockets(None)] for _ in range(2)
        )
        ports = {each.getsockname()[1] for each in first}, {each.getsockname()[1] for each in second}
    assert all(len(each) == 1 for each in ports)
    gc.collect()  # that socket, whose warning is ignored here only
    assert len({0, app.DEFAULT_PORT}.union(*ports)) == 4


def test_without_voila_one_line_says_what_to_install(monkeypatch, capsys):
    find = importlib.util.find_spec
    monkeypatch.setattr(app, "find_spec", lambda name: None if name == "voila" else find(name))
    assert command.main(["app"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert 'not installed: pip install "frictionlab[lab]"' in captured.err


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends ctrl-C to a whole console only")
@pytest.mark.parametrize("when", ["starting", "serving"])
def test_ctrl_c_ends_it_cleanly(when, tmp_path):
    pytest.importorskip("voila", reason="voila serves the page; it is not installed")
    command = [sys.executable, "-m", "frictionlab", "app", "--no-browser"]
    variables = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(
        command, env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            address = re.fullmatch(
                r"Models at (http://localhost:\d+/)models/\?token=[\w-]{43} \(ctrl-C ends it\)\n",
                process.stdout.readline(),
            )[1]
            second = process.stdout.readline()
            assert list(tmp_path.glob("frictionlab-*/explorer.ipynb"))
            answer = served(address) if when == "serving" else ""
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0
    assert re.fullmatch(r"One explorer with Python at http://localhost:\d+/\?token=[\w-]{43}\n", second)
    assert out == ""
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []
    assert ("default-src 'self'" in answer) == (when == "serving")


def served(address):
    """The policy that the server states, once it answers; without its token it starts no kernel."""
    for _ in range(300):
        try:
            urlopen(Request(address, method="HEAD"), timeout=60).close()
        except HTTPError as answer:
            with answer:
                return answer.headers["Content-Security-Policy"]
        except URLError:
            time.sleep(0.2)
    raise AssertionError("the server does not answer")
