"""Files that this package did not write: one entry is changed, then checksums are computed anew.

A mutation chooses a place in the data of a file at random, in its JSON or in an array, and puts another value
there, of another type, size or sign, or takes the entry away.
"""

from __future__ import annotations

import copy
import json
import random
import zipfile
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from tests.faults.damage import Damage

VALUES: dict[str, Callable[[Any], Any]] = {
    "None": lambda old: None,
    "True": lambda old: True,
    "minus one": lambda old: -1,
    "zero": lambda old: 0,
    "half": lambda old: 0.5,
    "10**9": lambda old: 10**9,
    "10**10 as float": lambda old: 1e10,
    "1e300": lambda old: 1e300,
    "10**400": lambda old: 10**400,
    "NaN": lambda old: float("nan"),
    "infinity": lambda old: float("inf"),
    "text": lambda old: "unknown",
    "no text": lambda old: "",
    "long text": lambda old: "x" * 100_000,
    "empty list": lambda old: [],
    "list of text": lambda old: ["a", "b"],
    "empty mapping": lambda old: {},
    "nested": lambda old: [[{"a": [None]}]],
    "deep": lambda old: _deep(),
    "in a list": lambda old: [old],
    "twice": lambda old: [*old, *old] if isinstance(old, list) else [old, old],
    "less one": lambda old: old[:-1] if isinstance(old, (list, str)) else None,
    "reversed": lambda old: old[::-1] if isinstance(old, (list, str)) else None,
    "negative": lambda old: -old if isinstance(old, (int, float)) else None,
    "as text": lambda old: str(old)[:100],
}
REMOVED = "removed"
ARRAYS: dict[str, Callable[[np.ndarray], np.ndarray | None]] = {
    "removed": lambda a: None,
    "less one": lambda a: a[:-1],
    "twice": lambda a: np.concatenate([a, a]),
    "empty": lambda a: a[:0],
    "negative": lambda a: -1 - a,
    "large": lambda a: a + 10**9,
    "reversed": lambda a: a[::-1],
    "a row": lambda a: a[None],
    "flat": lambda a: a.ravel(),
    "integers": lambda a: a.astype(np.int32),
    "complex": lambda a: a.astype(complex),
    "text": lambda a: a.astype(str),
    "truth values": lambda a: a.astype(bool),
    "big-endian": lambda a: a.astype(a.dtype.newbyteorder(">")),
    "infinite": lambda a: a * np.inf if a.dtype.kind == "f" else a.astype(float),
    "NaN": lambda a: a * np.nan if a.dtype.kind == "f" else a.astype(np.float32),
    "number": lambda a: np.zeros((), a.dtype),
}
SHAPES = [(10**12,), (2**62, 4), (10**400,), (-1,), (2**31, 2**31, 2**31), ("x",)]


def _deep() -> Any:
    found: Any = 0
    for _ in range(500):
        found = [found]
    return found


def mutations(count: int) -> Iterator[Damage]:
    """So many of them."""
    for seed in range(count):
        yield Damage(f"mutated {seed}", lambda path, seed=seed: mutate(path, seed))


def mutate(path: Path, seed: int) -> None:
    """Change one entry of a file of a run; prints nothing, raises nothing."""
    draw = random.Random(f"{seed} {path.name}")
    path.write_bytes(_mutated_run(path.read_bytes(), draw))


def _mutated_run(content: bytes, draw: random.Random) -> bytes:
    with zipfile.ZipFile(BytesIO(content)) as file:
        members = {name: file.read(name) for name in file.namelist()}
    name = draw.choice(["about.npy", draw.choice(sorted(members))])
    if name == "about.npy":
        about = json.loads(str(np.load(BytesIO(members[name]))))
        members[name] = _member(np.array(json.dumps(mutated(about, draw))))
    elif draw.random() < 0.3:
        members[name] = _declared(members[name], draw.choice(SHAPES))
    else:
        changed = ARRAYS[draw.choice(sorted(ARRAYS))](np.load(BytesIO(members[name])))
        members = {**members, name: None if changed is None else _member(changed)}
    written = BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as file:
        for each, data in members.items():
            if data is not None:
                file.writestr(each, data)
    return written.getvalue()


def _member(array: np.ndarray) -> bytes:
    written = BytesIO()
    np.save(written, array)
    return written.getvalue()


def _declared(member: bytes, shape: Any) -> bytes:
    """The member with another shape in its header."""
    array, written = np.load(BytesIO(member)), BytesIO()
    header = {"descr": array.dtype.str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(written, header)
    return written.getvalue() + array.tobytes()


def mutated(data: Any, draw: random.Random) -> Any:
    """A copy of JSON data with one entry changed or taken away; entries near the root as often as others."""
    found = copy.deepcopy(data)
    place = found
    while True:
        keys = [*place] if isinstance(place, dict) else [*range(len(place))]
        key = draw.choice(keys)
        inner = place[key]
        if not isinstance(inner, (dict, list)) or not inner or draw.random() < 0.3:
            break
        place = inner
    name = draw.choice([REMOVED, *VALUES])
    if name == REMOVED:
        del place[key]
    else:
        place[key] = VALUES[name](inner)
    return found
