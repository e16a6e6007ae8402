"""`frictionlab animate`, `sound`, `page` and `app`: a run as a film and as sound; a model to be tried in a
browser, as an exported page or by the explorer without a visible notebook.
"""

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
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    check_writable,
    complain,
    model_data,
    model_from_options,
    print_json,
)

if TYPE_CHECKING:
    import socket

FILM_FORMATS = (".gif", ".html", ".webp")  # those that need no other program
SOUND_FORMATS = (".wav",)
PERIODS = 300  # periods of a run where no end time is given: long enough to settle
DEFAULT_PORT = 8866
NOTEBOOK_CELL = "from frictionlab.widgets.scenes import open_scenes\n\nopen_scenes()"
EXIT_FAILED = 1

ANIMATE_DESCRIPTION = """\
Simulate a model and write a film of its moving parts, in slow motion: springs,
slider, belt and contact forces, coloured by what the contact does."""

ANIMATE_EPILOG = """\
examples:
  frictionlab animate -o slider.gif
  frictionlab animate --model TwoBlocks -o blocks.html --window 30 --fps 10

exit status: 0 written; 1 it could not be written; 2 bad arguments."""

SOUND_DESCRIPTION = """\
Simulate a model and write what its contact does as a sound, at a stated pitch:
the relative velocity unless --signal names another state or output."""

SOUND_EPILOG = """\
examples:
  frictionlab sound -o slider.wav
  frictionlab sound --model TwoBlocks --pitch 40 -o blocks.wav

exit status: 0 written; 1 it could not be written; 2 bad arguments."""

PAGE_DESCRIPTION = """\
Write a model as one HTML file with sliders, switches and the exact solver in
it. The file needs neither a server nor a network."""

PAGE_EPILOG = """\
examples:
  frictionlab page -o slider.html
  frictionlab page --model DenHartog -o den-hartog.html --slider F Omega N

exit status: 0 written; 1 it could not be written; 2 bad arguments."""

APP_DESCRIPTION = """\
Show the explorer (fl.explore) in the browser: scenes worth seeing and all
models from a menu, sliders, switches and pictures, no notebook. Everything is
served by this machine, to this machine, for whoever has the link that is
printed; no network is needed. Whoever holds the link runs code as you: give
it to nobody. At most four pages at once. ctrl-C ends it.
Needs Voila: pip install "frictionlab[lab]"."""

APP_EPILOG = """\
examples:
  frictionlab app
  frictionlab app --port 9000 --no-browser

exit status: 0 ended by ctrl-C; 1 Voila is not installed; 2 bad arguments."""


def add_animate(commands: Any) -> OneLineParser:
    """Add the command `animate`; returns its parser."""
    parser = _run_parser(commands, "animate", "write a film of a run", ANIMATE_DESCRIPTION, ANIMATE_EPILOG)
    parser.add_argument("-o", "--output", metavar="FILE", default="run.gif", help=f"{_list(FILM_FORMATS)}")
    parser.add_argument(
        "--window", type=float, metavar="S", help="the last so many seconds (default: 3 periods)"
    )
    parser.add_argument("--speed", type=float, metavar="X", help="seconds of the run in one of the film")
    parser.add_argument("--fps", type=float, default=15.0, metavar="N", help="frames a second (default: 15)")
    return parser


def add_sound(commands: Any) -> OneLineParser:
    """Add the command `sound`; returns its parser."""
    parser = _run_parser(commands, "sound", "write a run as sound", SOUND_DESCRIPTION, SOUND_EPILOG)
    parser.add_argument("-o", "--output", metavar="FILE", default="run.wav", help="a .wav (default: run.wav)")
    parser.add_argument("--signal", metavar="NAME", help="a state or an output, such as friction_force")
    parser.add_argument("--pitch", type=float, metavar="X", help="so many times faster than the motion")
    return parser


def add_page(commands: Any) -> OneLineParser:
    """Add the command `page`; returns its parser."""
    parser = add_command(
        commands,
        "page",
        "write a model as one HTML file with the exact solver in it",
        PAGE_DESCRIPTION,
        PAGE_EPILOG,
    )
    parser.add_argument("-o", "--output", metavar="FILE", default="slider.html", help="default: slider.html")
    add_model_options(parser)
    parser.add_argument("--slider", nargs="+", metavar="NAME", help="sliders shown at first")
    parser.add_argument("--t-end", type=float, metavar="S", help="end time (default: some 300 periods)")
    add_json(parser)
    return parser


def add_app(commands: Any) -> OneLineParser:
    """Add the command `app`; returns its parser."""
    parser = add_command(
        commands, "app", "show the explorer in the browser, without a notebook", APP_DESCRIPTION, APP_EPILOG
    )
    text = f"port of this machine (default: {DEFAULT_PORT}, or any free one)"
    parser.add_argument("--port", type=int, metavar="N", help=text)
    parser.add_argument("--no-browser", action="store_true", help="open no browser, only print the address")
    return parser


def _list(formats: tuple[str, ...]) -> str:
    return f"{', '.join(formats)} (default: run{formats[0]})"


def _run_parser(commands: Any, name: str, about: str, description: str, epilog: str) -> OneLineParser:
    parser = add_command(commands, name, about, description, epilog)
    add_model_options(parser)
    parser.add_argument("--x0", default="rest", metavar="STATE", help="rest or near (default: rest)")
    parser.add_argument(
        "--t-end", type=float, metavar="S", help="length of the run (default: some 300 periods)"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    add_json(parser)
    return parser


def animate_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the film; returns the exit status."""
    from frictionlab.interruption import progress
    from frictionlab.plotting import animate
    from frictionlab.plotting.animation.animate import DEFAULT_WINDOW

    with progress(not (chosen.quiet or chosen.json)):
        run = _checked_run(chosen, parser, FILM_FORMATS)
        window = DEFAULT_WINDOW if chosen.window is None else chosen.window
        try:
            film = animate(run, window=window, speed=chosen.speed, fps=chosen.fps)
        except ValueError as error:
            parser.error(str(error))
        return _write(film, chosen, parser, {**model_data(run.source), "t_end": run.raw.t})


def sound_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the sound; returns the exit status."""
    from frictionlab.interruption import progress
    from frictionlab.widgets.sound import listen

    with progress(not (chosen.quiet or chosen.json)):
        run = _checked_run(chosen, parser, SOUND_FORMATS)
        try:
            sound = listen(run, chosen.signal, pitch=chosen.pitch)
        except ValueError as error:
            parser.error(str(error))
        about = {"t_end": run.raw.t, "signal": sound.signal, "pitch": sound.pitch}
        return _write(sound, chosen, parser, {**model_data(run.source), **about})


def page_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the page; returns the exit status."""
    import frictionlab as fl
    from frictionlab.pages.export import SolverNotBuiltError

    try:
        model = model_from_options(chosen)
        path = fl.export_page(model, chosen.output, sliders=chosen.slider, t_end=chosen.t_end)
    except SolverNotBuiltError as error:
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    print_json({**model_data(model), "file": path}) if chosen.json else print(f"wrote {path}")
    return 0


def _checked_run(chosen: argparse.Namespace, parser: OneLineParser, formats: tuple[str, ...]) -> Any:
    """A run of the chosen model; the options are checked before it."""
    from frictionlab.analysis.motion_scales import oscillation_period, round_down_1_2_5
    from frictionlab.analysis.simulate import simulate
    from frictionlab.validation import check_number

    path = Path(chosen.output)
    try:
        if path.suffix.lower() not in formats:
            listed = ", ".join(formats)
            raise ValueError(f"-o must end in one of {listed}, got {chosen.output!r}: take {formats[0]}")
        check_writable(path, "-o")
        model = model_from_options(chosen)
        if chosen.t_end is None:
            chosen.t_end = round_down_1_2_5(PERIODS * oscillation_period(model))
        check_number("--t-end", chosen.t_end, above=0.0, cure="give the length of the run in seconds")
        return simulate(model, chosen.t_end, x0=chosen.x0)
    except (ValueError, TypeError) as error:
        parser.error(str(error))


def _write(made: Any, chosen: argparse.Namespace, parser: OneLineParser, data: dict[str, Any]) -> int:
    path = Path(chosen.output)
    options = {} if path.suffix.lower() in (".wav", ".html") else {"writer": "pillow"}
    try:
        made.save(path, **options)
    except OSError as error:
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    print_json({**data, "file": str(path)}) if chosen.json else print(f"wrote {path}")
    return 0


def app_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Serve until ctrl-C; returns the exit status."""
    if chosen.port is not None and not 1 <= chosen.port <= 65535:
        parser.error(f"--port must be from 1 to 65535, got {chosen.port}: leave it out for {DEFAULT_PORT}")
    if find_spec("voila") is None:
        cure = 'pip install "frictionlab[lab]"'
        complain(parser.prog, f"error: the page needs Voila, which is not installed: {cure}")
        return EXIT_FAILED
    try:
        sockets = listening_sockets(chosen.port)
    except OSError as error:
        cure = "give another, or leave it out for any that is free"
        parser.error(f"--port {chosen.port} cannot be had ({error.strerror}): {cure}")
    with TemporaryDirectory(prefix="frictionlab-") as folder, contextlib.suppress(KeyboardInterrupt):
        notebook = Path(folder) / "explorer.ipynb"
        notebook.write_text(json.dumps(_notebook()), encoding="utf-8")
        token = secrets.token_urlsafe(32)
        port = sockets[0].getsockname()[1]
        print(f"Explorer at http://localhost:{port}/?token={token} (ctrl-C ends it)", flush=True)
        _serve_until_stopped(notebook, sockets, token, browser=not chosen.no_browser)
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
