"""Claims C9 and C10, on single motions: Figs 7 and 8."""

from __future__ import annotations

import numpy as np

from . import motions
from .compare import Finding, Question
from .responses import example, in_words
from .setting import Setting
from .wording import AT_REST, NON_PERIODIC, PERIODIC

EXPECTED = {
    "near": ("rest", "rest", "vibration"),
    "rest": ("rest", "vibration", "vibration"),
}
BEGINNING = {"near": "near", "rest": "far"}
CYCLE = 1.58, 0.005  # Hz, and half a unit of its last digit


def _kinds(kinds: tuple[str, ...]) -> list[str]:
    words: dict[str, str] = {AT_REST: "rest", PERIODIC: "vibration", NON_PERIODIC: "vibration"}
    return [words.get(kind, kind) for kind in kinds]


def _starts(setting: Setting) -> Finding:
    found = {start: motions.examples(start, setting) for start in motions.STARTS}
    held, text = {}, []
    for start, b in found.items():
        for mu, kind, expected in zip(b.values, _kinds(b.kinds), EXPECTED[start]):
            held[f"{BEGINNING[start]} at {mu:g} leads to {expected}"] = kind == expected
        rows = (f"{kind} ({s:.4g}) at {mu:g}" for mu, kind, s in zip(b.values, b.kinds, b.intensities))
        text.append(f"{BEGINNING[start]}: {', '.join(rows)}")
    held["near and far lead to the same kind of motion at 2.5"] = (
        len({b.kinds[-1] for b in found.values()}) == 1
    )
    return Finding(f"kind (L_s in m^2) at mu_k: {'; '.join(text)}", held)


def _cycles(setting: Setting) -> Finding:
    low, high = example(1.4, setting), example(2.5, setting)
    frequency = 1 / low.period if low.kind == PERIODIC else np.nan
    held = {
        "the motion at 1.4 is periodic": low.kind == PERIODIC,
        "its frequency is 1.58 Hz": bool(abs(frequency - CYCLE[0]) <= CYCLE[1]),
        "the motion at 2.5 is non-periodic": high.kind == NON_PERIODIC,
    }
    return Finding(f"mu_k 1.4: {in_words(low)}; mu_k 2.5: {in_words(high)}", held)


CHECKS = {
    "C9": Question(
        "Fig. 7",
        "mu_k 0.3: near and far go to the equilibrium; 1.4: near to the equilibrium, far to a limit cycle; "
        "2.5: both to the limit cycle",
        _starts,
    ),
    "C10": Question(
        "Fig. 8", "steady state periodic at mu_k 1.4, about 1.58 Hz; non-periodic at 2.5", _cycles
    ),
}
