"""Writes what the tests compare with, by the high-precision reference; takes some three minutes.

    python -m tests.reference.write_tables

first_events.json: twenty events of the scenes A, B and D from rest, D without a limit for chatter.
events_A.csv, events_B.csv, events_D.csv: every event of the first second, to 25 digits, D with chatter
replaced by its limit below flights of 1e-7 s, as the package does unless told otherwise. States before and
after an event are left out of most flights of chatter. The last row is the state at the end.
events_D_fine.csv: D with flights walked through down to 1e-9 s, without these flights and without states.
"""

import csv
import json
from pathlib import Path

from mpmath import mp, mpf

from tests.reference.slider_mpmath import NUMERICS, Happening, Start, first_events, motion, state_at

HERE = Path(__file__).parent
FLIGHT, EVERY = ("separation", "separation"), 20
SCENES = {
    name: {"mu_k": "1.4", "geometry": geometry, "impact": impact}
    for name, geometry, impact in (("A", False, "full"), ("B", True, "full"), ("D", True, "material"))
}
TABLES = {
    "A": SCENES["A"],
    "B": SCENES["B"],
    "D": {**SCENES["D"], "chatter": "1e-7"},
    "D_fine": {**SCENES["D"], "chatter": "1e-9"},
}


def scene_record(scene, with_state):
    """First twenty events of a scene, and its state at 0.2 s if wanted, as text with 30 digits."""
    text = {"n": 30, "strip_zeros": False}
    events = [[mp.nstr(t, **text), source, target] for t, source, target in first_events(20, **scene)]
    state = {"state_at_0.2": [mp.nstr(x, **text) for x in state_at("0.2", **scene)]} if with_state else {}
    return {**scene, "events": events, **state}


def digits(values):
    """Numbers as text."""
    return [mp.nstr(x, 25) for x in values]


def rows(name, numerics=NUMERICS):
    """The table of a scene's first second."""
    events, end = motion(1, **TABLES[name], numerics=numerics)
    fine = name == "D_fine"
    for number, (t, source, target, before, after) in enumerate(events):
        flight = (source, target) == FLIGHT
        if fine and flight:
            continue
        states = [] if fine or (flight and number % EVERY) else digits(before + after)
        yield [*digits([t]), source, target, *states]
    yield [*digits([mpf(1)]), events[-1].target, "end", *digits(end)]


def write(name):
    """Write a scene's table."""
    with open(HERE / f"events_{name}.csv", "w", newline="\n", encoding="utf-8") as stream:
        stream.write(
            "# python -m tests.reference.write_tables: t, source, target, state before, state after\n"
        )
        csv.writer(stream, lineterminator="\n").writerows(rows(name))


def read(name):
    """Rows (Happening) of a table as mpf, with None for states left out; the last holds the end's state."""
    lines = (HERE / f"events_{name}.csv").read_text(encoding="utf-8").splitlines()
    with mp.workdps(NUMERICS["dps"]):
        return [_row(*row) for row in csv.reader(lines[1:])]


def _row(t, source, target, *states):
    numbers = [mpf(x) for x in states]
    half = len(numbers) if target == "end" else len(numbers) // 2
    return Happening(mpf(t), source, target, numbers[:half] or None, numbers[half:] or None)


def resumed(name, row, t_stop):
    """The scene once more from a row of its table on, which has to be a flight that begins: its events."""
    state = row.after if len(row.after) == 10 else [*row.after[:4], mpf(0), *row.after[4:], mpf(0)]
    start = Start(row.t, row.target, state, {"gap": 1})
    return motion(t_stop, **TABLES[name], start=start)[0]


if __name__ == "__main__":
    record = {name: scene_record(scene, with_state=name != "D") for name, scene in SCENES.items()}
    command = "python -m tests.reference.write_tables"
    text = json.dumps({"command": command, "digits": 30, "scenes": record}, indent=1)
    (HERE / "first_events.json").write_text(text + "\n")
    for table in TABLES:
        write(table)
