"""Claims C11 to C15, with all three nonlinearities: Figs 9 to 12."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import spearmanr

from . import motions, scenes
from .compare import Finding, Question
from .setting import Setting
from .wording import AT_REST, NON_PERIODIC, PERIODIC, are, count, moving, stretches, within

ALIKE = 0.1  # share of its largest size within which a section value counts as nearly the same
TREND = 0.5  # rank correlation with mu_k above which the intensity "generally gets stronger"


def _sections(setting: Setting) -> Finding:
    """C11."""
    b = motions.from_rest(1e4, setting)
    ranges = {
        "periodic for 0.9 <= mu_k < 1.8": (PERIODIC, 0.9, 1.8),
        "non-periodic for 0.4 <= mu_k < 0.9": (NON_PERIODIC, 0.4, 0.9),
        "non-periodic for 1.8 <= mu_k < 3": (NON_PERIODIC, 1.8, 3.0),
    }
    return Finding(*_by_range(b, ranges))


def _by_range(b: Any, ranges: dict[str, tuple[str, float, float]]) -> tuple[str, dict[str, bool]]:
    """Stretches and counts in words, and whether each range is of one kind throughout."""
    held, counts = {}, []
    for text, (kind, first, last) in ranges.items():
        there = are(b, kind)[within(b, first, last, open_end=True)]
        held[text] = bool(there.all())
        counts.append(f"{text} at {count(there)} values")
    return f"{stretches(b)} ({'; '.join(counts)})", held


def _coexist(setting: Setting) -> Finding:
    """C12."""
    rest, near = motions.from_rest(1e4, setting), motions.from_near(1e4, setting)
    low, high = within(rest, 0.0, 0.4, open_end=True), near.values > 1.5 + 1e-9
    held = {
        "only the equilibrium for mu_k < 0.4": bool(are(rest, AT_REST)[low].all()),
        "only the limit cycle for mu_k > 1.5": bool(moving(near)[high].all()),
        "both in [0.4, 1.5]": _both(rest, near, 0.4, 1.5),
    }
    return Finding(f"from rest {stretches(rest)}; from near {stretches(near)}", held)


def _both(rest: Any, near: Any, first: float, last: float) -> bool:
    """Whether from rest it vibrates and from near it comes to rest, all through a range."""
    vibrates = moving(rest)[within(rest, first, last)].all()
    return bool(vibrates and are(near, AT_REST)[within(near, first, last)].all())


def _soft(setting: Setting) -> Finding:
    """C13."""
    b = motions.from_rest(0.0, setting)
    there, odd = within(b, 0.9, 1.8, open_end=True), within(b, 1.3, 1.3)
    periodic = are(b, PERIODIC)
    held = {"periodic for 0.9 <= mu_k < 1.8 but at 1.3": bool(periodic[there & ~odd].all())}
    for mu, expected in (1.3, False), (0.05, True):
        at = within(b, mu, mu)
        if at.any():  # a quick grid does not hold every value
            text = "a periodic cycle" if expected else "no periodic motion"
            held[f"{text} at {mu:g}"] = bool(periodic[at].all() == expected)
    return Finding(f"{stretches(b)} (periodic at {count(periodic[there])} values in [0.9, 1.8))", held)


def _hard(setting: Setting) -> Finding:
    """C14."""
    b = motions.from_rest(1e7, setting)
    there, at, periodic = within(b, 0.75, 2.9), within(b, 0.1, 0.1), are(b, PERIODIC)
    x1 = np.concatenate([s[:, b.names.index("x1")] for s, t in zip(b.sections, there) if t and len(s)])
    held = {"periodic for 0.75 <= mu_k <= 2.9": bool(periodic[there].all())}
    if at.any():
        held["periodic at 0.1"] = bool(periodic[at].all())
    held["nearly the same section values there"] = bool(np.ptp(x1) < ALIKE * np.abs(x1).max())
    counts = (
        f"periodic at {count(periodic[there])} values in [0.75, 2.9], x1 {x1.min():.5f} to {x1.max():.5f} m"
    )
    return Finding(f"{stretches(b)} ({counts})", held)


def _strength(setting: Setting) -> Finding:
    """C15."""
    held, text = {}, []
    for k_nl in scenes.SOFT_AND_HARD:
        rest, near = motions.from_rest(k_nl, setting), motions.from_near(k_nl, setting)
        first, last = (0.4, 1.5) if k_nl < 1e7 else (0.0, 0.6)
        both = "[0.4, 1.5]" if k_nl < 1e7 else "(0, 0.6]"
        held[f"both coexist in {both} for k_nl {k_nl:g}"] = _both(rest, near, first, last)
        vibrates = moving(rest)
        if k_nl < 1e7:
            ranks: Any = spearmanr(rest.values[vibrates], rest.intensities[vibrates])
            trend = float(ranks[0])
            held[f"L_s grows with mu_k for k_nl {k_nl:g}"] = bool(trend > TREND)
            text.append(f"k_nl {k_nl:g}: {_coexistence(rest, near)}, rank correlation of L_s {trend:.2f}")
        else:
            inside = within(rest, 0.75, 2.9)
            weak, strong = (_mean(rest.intensities[vibrates & w]) for w in (inside, ~inside))
            held["L_s is lower in [0.75, 2.9] for k_nl 1e7"] = bool(weak < strong)
            means = f"mean L_s {weak:.4g} in [0.75, 2.9], {strong:.4g} outside"
            text.append(f"k_nl 1e7: {_coexistence(rest, near)}, {means}")
    return Finding("; ".join(text), held)


def _coexistence(rest: Any, near: Any) -> str:
    shared = [v for v, m in zip(rest.values, moving(rest)) if m and v in near.values[are(near, AT_REST)]]
    return f"both at {shared[0]:g} to {shared[-1]:g}" if shared else "nowhere both"


def _mean(values: Any) -> float:
    return float(np.mean(values)) if len(values) else np.nan


CHECKS = {
    "C11": Question(
        "Fig. 9",
        "x1 at the onset of stick: periodic for 0.9 <= mu_k < 1.8, "
        "non-periodic for 0.4 <= mu_k < 0.9 and 1.8 <= mu_k < 3",
        _sections,
    ),
    "C12": Question(
        "Fig. 10",
        "only the equilibrium for mu_k < 0.4, only the limit cycle for mu_k > 1.5, both in [0.4, 1.5]",
        _coexist,
    ),
    "C13": Question(
        "Fig. 11a",
        "k_nl = 0: periodic for 0.9 <= mu_k < 1.8 except 1.3; also a stable periodic cycle at 0.05",
        _soft,
    ),
    "C14": Question(
        "Fig. 11b",
        "k_nl = 1e7 N/m^3: periodic for 0.75 <= mu_k <= 2.9 and at 0.1, nearly the same section values there",
        _hard,
    ),
    "C15": Question(
        "Fig. 12",
        "both solutions coexist in [0.4, 1.5] for k_nl 0 and 1e4, in (0, 0.6] for 1e7; L_s grows with mu_k "
        "for 0 and 1e4; for 1e7 it is lower where the motion is periodic",
        _strength,
    ),
}
