"""`frictionlab app`: the explorer in the browser, without a visible notebook."""

from __future__ import annotations

import argparse
import contextlib
import json
import secrets
import signal
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from .parsing import (
    EXIT_FAILED,
    OneLineParser,
    add_command,
    complain,
)

if TYPE_CHECKING:
    import socket

DEFAULT_PORT = 8866
NOTEBOOK_CELL = "from frictionlab.widgets.scenes import Scenes\n\nScenes(address=True)"

APP_DESCRIPTION = """\
Show the explorer (fl.explore) in the browser: scenes worth seeing and all
models, sliders, switches and pictures, no notebook. The first link shows
pages that the browser computes alone, as many as you like; the second one the
explorer whose engine is Python (at most four at once). Everything is served by
this machine, to this machine, for whoever has a link that is printed; no
network is needed. Whoever holds a link runs code as you: give it to nobody.
ctrl-C ends it.
Needs Voila: pip install "frictionlab[lab]"."""

APP_EPILOG = """\
examples:
  frictionlab app
  frictionlab app --port 9000 --no-browser

exit status: 0 ended by ctrl-C; 1 Voila is not installed; 2 bad arguments."""


def add_app(commands: Any) -> OneLineParser:
    """Add the command `app`; returns its parser."""
    parser = add_command(
        commands, "app", "show the explorer in the browser, without a notebook", APP_DESCRIPTION, APP_EPILOG
    )
    text = f"port of this machine (default: {DEFAULT_PORT}, or any free one)"
    parser.add_argument("--port", type=int, metavar="N", help=text)
    parser.add_argument("--no-browser", action="store_true", help="open no browser, only print the address")
    return parser


def app_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Serve until ctrl-C; returns the exit status."""
    if args.port is not None and not 1 <= args.port <= 65535:
        parser.error(f"--port must be from 1 to 65535, got {args.port}: leave it out for {DEFAULT_PORT}")
    if find_spec("voila") is None:
        cure = 'pip install "frictionlab[lab]"'
        complain(parser.prog, f"error: the page needs Voila, which is not installed: {cure}")
        return EXIT_FAILED
    try:
        sockets = listening_sockets(args.port)
    except OSError as error:
        cure = "give another, or leave it out for any that is free"
        parser.error(f"--port {args.port} cannot be had ({error.strerror}): {cure}")
    with TemporaryDirectory(prefix="frictionlab-") as folder, contextlib.suppress(KeyboardInterrupt):
        notebook = Path(folder) / "explorer.ipynb"
        notebook.write_text(json.dumps(_notebook()), encoding="utf-8")
        token = secrets.token_urlsafe(32)
        port = sockets[0].getsockname()[1]
        print(f"Models at http://localhost:{port}/models/?token={token} (ctrl-C ends it)")
        print(f"One explorer with Python at http://localhost:{port}/?token={token}", flush=True)
        _serve_until_stopped(notebook, sockets, token, browser=not args.no_browser)
    return 0


def listening_sockets(port: int | None) -> list[socket.socket]:
    """Sockets of this machine at a port; by default at the usual one, or at any free one if that is taken.

    They listen from here on, so that no other process can take the port whose link is printed.
    """
    from tornado.netutil import bind_sockets

    if port is not None:
        return bind_sockets(port, "localhost")
    try:
        return bind_sockets(DEFAULT_PORT, "localhost")
    except OSError:
        return bind_sockets(0, "localhost")


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


def _serve_until_stopped(notebook: Path, sockets: list[socket.socket], token: str, browser: bool) -> None:
    from .app_server import serve  # needs Voila

    signal.signal(signal.SIGINT, _stop)
    serve(notebook, sockets, token, browser)


def _stop(number: int, frame: Any) -> None:
    """End the server's loop; a KeyboardInterrupt may be lost if it is raised in a callback from C."""
    from tornado.ioloop import IOLoop

    loop = IOLoop.current(instance=False)
    if loop is None:  # not yet serving
        raise KeyboardInterrupt
    loop.add_callback_from_signal(loop.stop)
