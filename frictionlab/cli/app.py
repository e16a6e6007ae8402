"""`frictionlab app`: the explorer as a page of its own, without a visible notebook."""

from __future__ import annotations

import argparse
import json
import signal
import socket
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from .parsing import OneLineParser, complain

EXIT_FAILED = 1
DEFAULT_PORT = 8866
NOTEBOOK_CELL = "import frictionlab as fl\n\nfl.explore()"

DESCRIPTION = """\
Show the explorer (fl.explore) in the browser: sliders, switches and pictures,
no notebook. Everything is served by this machine, to this machine; no network
is needed. ctrl-C ends it. Needs Voila: pip install "frictionlab[lab]"."""

EPILOG = """\
examples:
  frictionlab app
  frictionlab app --port 9000 --no-browser

exit status: 0 ended by ctrl-C; 1 Voila is not installed; 2 bad arguments."""

# Voila's page requests an optional style sheet from another server, and stays blank until that answers
# or fails: with that request forbidden the page appears at once, also without a network.
CONTENT_SECURITY_POLICY = (
    "default-src 'self' ws: data: blob: 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'self'"
)


def add_app(commands: Any) -> OneLineParser:
    """Add the command `app`; returns its parser."""
    parser = commands.add_parser(
        "app",
        help="show the explorer in the browser, without a notebook",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    text = f"port of this machine (default: {DEFAULT_PORT}, or any free one)"
    parser.add_argument("--port", type=int, metavar="N", help=text)
    parser.add_argument("--no-browser", action="store_true", help="open no browser, only print the address")
    return parser


def app_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Serve until ctrl-C; returns the exit status."""
    if chosen.port is not None and not 1 <= chosen.port <= 65535:
        parser.error(f"--port must be from 1 to 65535, got {chosen.port}: leave it out for {DEFAULT_PORT}")
    if find_spec("voila") is None:
        cure = 'pip install "frictionlab[lab]"'
        complain(parser.prog, f"error: the page needs Voila, which is not installed: {cure}")
        return EXIT_FAILED
    try:
        port = choose_port(chosen.port)
    except OSError as error:
        cure = "give another, or leave it out for any that is free"
        parser.error(f"--port {chosen.port} cannot be had ({error.strerror}): {cure}")
    with TemporaryDirectory(prefix="frictionlab-") as folder:
        notebook = Path(folder) / "explorer.ipynb"
        notebook.write_text(json.dumps(_notebook()), encoding="utf-8")
        print(f"Explorer at http://localhost:{port}/ (ctrl-C ends it)", flush=True)
        _serve(notebook, port, browser=not chosen.no_browser)
    return 0


def choose_port(asked: int | None) -> int:
    """The port asked for; by default the usual one, or any free one if that is taken."""
    if asked is not None:
        return _bind_port(asked)
    try:
        return _bind_port(DEFAULT_PORT)
    except OSError:
        return _bind_port(0)


def _bind_port(port: int) -> int:
    # Voila would tell of failure in its log only.
    with socket.create_server(("localhost", port)) as probe:
        return probe.getsockname()[1]


def _notebook() -> dict[str, Any]:
    cell = {
        "cell_type": "code",
        "execution_count": None,
        "metadata": {},
        "outputs": [],
        "source": NOTEBOOK_CELL,
    }
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"cells": [cell], "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}


def _serve(notebook: Path, port: int, browser: bool) -> None:
    from voila.app import Voila

    options = [str(notebook), f"--port={port}", "--Voila.port_retries=0", "--show_tracebacks=True"]
    options += ["--Voila.log_level=ERROR"] + ([] if browser else ["--no-browser"])
    settings = {"headers": {"Content-Security-Policy": CONTENT_SECURITY_POLICY}}
    signal.signal(signal.SIGINT, _stop)
    Voila.launch_instance(options, tornado_settings=settings)


def _stop(number: int, frame: Any) -> None:
    """End the server's loop; a KeyboardInterrupt may be lost, where Python calls back from C."""
    from tornado.ioloop import IOLoop

    loop = IOLoop.current(instance=False)
    if loop is None:  # not yet serving
        raise KeyboardInterrupt
    loop.add_callback_from_signal(loop.stop)
