"""Files of runs and sweeps, damaged in every way: read as they were, or refused with path and cure.

Mutated ones of runs, whose checksums are right, may be read as something else, which then can be used.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import frictionlab as fl
from tests.faults.damage import damages
from tests.faults.mutations import mutations
from tests.faults.processes import Report, in_a_process, judge, other_user
from tests.helpers.own_models import Chain, Fitted

SLIDER = fl.SliderOnBelt(mu_k=1.4).without("geometry")
QUIET: dict[str, Any] = {"progress": False}
MOST_BYTES = 6_000_000_000  # of a process that reads a file
SHORT: dict[str, Any] = {"transient": 5.0, "window": 2.0, "workers": 1, **QUIET}


class Stored(NamedTuple):
    """A kind of file: what makes it, and what reads it again, as a value that pickles hold.

    What is read of a file that was cut may be a part of the whole; `complete` where it must be all.
    """

    make: Callable[[Path], Any]
    read: Callable[[Path], Any]
    complete: bool = True


def content(run: Any) -> tuple[bytes, ...]:
    """All arrays of a run."""
    arrays = (run.raw.step_times, run.raw.step_states, run.events.t, run.events.state, run.final_state)
    return tuple(array.tobytes() for array in arrays)


def bifurcation(path: Path) -> Any:
    return fl.bifurcation(SLIDER, "mu_k", [0.5, 0.8, 1.1], resume=path, **SHORT)


def sweep(path: Path) -> Any:
    return fl.sweep(Chain(friction=Fitted()), speed, {"v": [0.1, 0.2, 0.3]}, resume=path, workers=1, **QUIET)


def basins(path: Path) -> Any:
    return fl.basins(SLIDER, ("x1'", [0.0, 0.25]), ("y1'", [0.0, 0.1]), "near", resume=path, **SHORT)


def speed(model: Any) -> dict[str, float]:
    return {"v": model.v, "share": model.v / 3}


def resumed(compute: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Reads by going on, to the whole file."""
    return lambda path: (compute(path), {0: path.read_bytes()})[1]


MADE: dict[str, Callable[[Path], Any]] = {
    "run": lambda path: fl.simulate(SLIDER, 1.0, **QUIET).save(path),
    "run of an automaton": lambda path: fl.solve(SLIDER.automaton(), 1.0, x0=[0.0] * 8, **QUIET).save(path),
    "run of modes on demand": lambda path: fl.solve(
        fl.TwoBlocks().automaton(), 2.0, x0=[0.0] * 4, **QUIET
    ).save(path),
    "run of own laws": lambda path: fl.simulate(Chain(friction=Fitted()), 2.0, **QUIET).save(path),
    "bifurcation": bifurcation,
    "basins": basins,
    "resumed bifurcation": bifurcation,
    "resumed sweep": sweep,
    "resumed basins": basins,
}
STORED = {
    **{
        name: Stored(MADE[name], lambda path: content(fl.load(path)))
        for name in ("run", "run of an automaton", "run of modes on demand", "run of own laws")
    },
    "bifurcation": Stored(bifurcation, lambda path: fl.load_bifurcation(path).results, complete=False),
    "basins": Stored(basins, lambda path: fl.load_basins(path).results, complete=False),
    "resumed bifurcation": Stored(bifurcation, resumed(bifurcation)),
    "resumed sweep": Stored(sweep, resumed(sweep)),
    "resumed basins": Stored(basins, resumed(basins)),
}


def used(found: Any) -> Any:
    """A result of a file, after what users do with it."""
    repr(found)
    if isinstance(found, fl.Trajectory):
        found(found.t[:3]), found.stats, found.warning, found.events.counts(), str(found.status)
    return None


USED: dict[str, Callable[[Path], Any]] = {
    "run": lambda path: used(fl.load(path)),
    "run of an automaton": lambda path: used(fl.load(path)),
    "run of modes on demand": lambda path: used(fl.load(path)),
}


def main(scratch: Path, truncations: int, flips: int, mutated: int) -> int:
    """Do all damages to all kinds of files; returns how many were not withstood."""
    scratch.chmod(0o755)
    return _damaged(scratch, truncations, flips) + _mutated(scratch, mutated)


def _mutated(scratch: Path, count: int) -> int:
    failed = 0
    for name, use in USED.items():
        report, folder = Report(f"mutated {name}"), scratch / f"mutated-{name.replace(' ', '-')}"
        folder.mkdir()
        whole, path = folder / "whole.npz", folder / "file.npz"
        MADE[name](whole)
        for mutation in mutations(count):
            shutil.copy(whole, path)
            mutation.do(path)
            found = in_a_process(lambda use=use, path=path: (limit_memory(), use(path), None)[-1])
            report.add(f"{name}, {mutation.name}", judge(found, path, lambda value: True))
        failed += report.finish()
    return failed


def limit_memory() -> None:
    """Let this process have no more than some GB."""
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, resource.RLIM_INFINITY))


def _damaged(scratch: Path, truncations: int, flips: int) -> int:
    failed = 0
    for name, kind in STORED.items():
        report, folder, whole = Report(name), scratch / name.replace(" ", "-"), scratch / f"{name} whole.npz"
        folder.mkdir()
        path = folder / "file.npz"
        kind.make(path)
        shutil.copy(path, whole)
        expected = in_a_process(lambda kind=kind, path=path: kind.read(path)).value
        for damage in damages(truncations, flips):
            for left in folder.iterdir():
                shutil.rmtree(left) if left.is_dir() else left.unlink()
            shutil.copy(whole, path)
            path.chmod(0o644)
            damage.do(path)
            user = other_user(damage.as_nobody)
            found = in_a_process(lambda kind=kind, path=path: kind.read(path), user)
            report.add(f"{name}, {damage.name}", judge(found, path, acceptor(kind, expected)))
        failed += report.finish()
    return failed


def acceptor(kind: Stored, expected: Any) -> Callable[[Any], bool]:
    """Whether what was read is that of the whole file, or of files that may be cut a part of it."""
    if kind.complete:
        return lambda value: value == expected
    return lambda value: all(task in expected and same(value[task], expected[task]) for task in value)


def same(one: Any, other: Any) -> bool:
    """Equal, with NaN equal to itself."""
    return repr(one) == repr(other)
