"""`frictionlab animate` and `frictionlab sound`: a run as a film in slow motion, and as a sound."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from frictionlab.validation import check_path

from .parsing import (
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    check_writable,
    model_data,
    model_from_options,
    print_json,
)

FILM_HELP = ".gif, .html or .webp; where there is ffmpeg also .mp4 and others (default: run.gif)"
SOUND_FORMATS = (".wav",)

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


def add_animate(commands: Any) -> OneLineParser:
    """Add the command `animate`; returns its parser."""
    parser = _run_parser(commands, "animate", "write a film of a run", ANIMATE_DESCRIPTION, ANIMATE_EPILOG)
    parser.add_argument("-o", "--output", metavar="FILE", default="run.gif", help=FILM_HELP)
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


def _run_parser(commands: Any, name: str, about: str, description: str, epilog: str) -> OneLineParser:
    parser = add_command(commands, name, about, description, epilog)
    add_model_options(parser)
    parser.add_argument("--x0", default="rest", metavar="STATE", help="rest or near (default: rest)")
    parser.add_argument(
        "--t-end", type=float, metavar="S", help="end time (default: 200 periods, fewer for a stiff model)"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    add_json(parser)
    return parser


def animate_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the film; returns the exit status."""
    from frictionlab.interruption import progress
    from frictionlab.plotting import animate
    from frictionlab.plotting.animation.animate import DEFAULT_WINDOW, check_film_path

    with progress(not (args.quiet or args.json)):
        run = _checked_run(args, parser, check_film_path)
        window = DEFAULT_WINDOW if args.window is None else args.window
        try:
            film = animate(run, window=window, speed=args.speed, fps=args.fps)
        except ValueError as error:
            parser.error(str(error))
        return _write(film, args, {**model_data(run.source), "t_end": run.raw.t})


def sound_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the sound; returns the exit status."""
    from frictionlab.interruption import progress
    from frictionlab.widgets.sound import listen

    with progress(not (args.quiet or args.json)):
        run = _checked_run(args, parser, partial(check_path, suffixes=SOUND_FORMATS))
        try:
            sound = listen(run, args.signal, pitch=args.pitch)
        except ValueError as error:
            parser.error(str(error))
        about = {"t_end": run.raw.t, "signal": sound.signal, "pitch": sound.pitch}
        return _write(sound, args, {**model_data(run.source), **about})


def _checked_run(
    args: argparse.Namespace, parser: OneLineParser, check_file: Callable[[str, str], Path]
) -> Any:
    """A run of the chosen model; the options are checked before it."""
    from frictionlab.analysis.period_of_motion import oscillation_period
    from frictionlab.analysis.simulate import simulate
    from frictionlab.pages.scene import usual_duration
    from frictionlab.validation import check_number

    try:
        check_writable(check_file("-o", args.output), "-o")
        model = model_from_options(args)
        if args.t_end is None:
            args.t_end = usual_duration(model, oscillation_period(model, args.x0))
        check_number("--t-end", args.t_end, above=0.0, cure="give the length of the run in seconds")
        return simulate(model, args.t_end, x0=args.x0)
    except (ValueError, TypeError) as error:
        parser.error(str(error))


def _write(result: Any, args: argparse.Namespace, data: dict[str, Any]) -> int:
    path = Path(args.output)
    options = {} if path.suffix.lower() in (".wav", ".html") else {"writer": "pillow"}
    result.save(path, **options)
    print_json({**data, "file": str(path)}) if args.json else print(f"wrote {path}")
    return 0
