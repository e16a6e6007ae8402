"""Claims C21 to C25, with and without the non-smooth behaviours: Figs 16 to 18."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import motions
from .compare import Finding, Question
from .frequencies import LEFT_OUT, in_words, panel
from .printed import agrees
from .setting import Setting
from .smoothness import WITH, WITHOUT, compared, critical, ranges
from .wording import NON_PERIODIC, PERIODIC, are, count, moving, stretches, within

MUCH = 2.0  # times: "much larger"
CLOSE = 0.02  # of the eigenfrequency: "close"
SYMBOLS = {"x1": ("x1", "m"), "y1": ("y1", "m"), "normal_force": ("F_N", "N")}


def _amplitudes(setting: Setting) -> Finding:
    """C21."""
    found = compared(setting)
    with_all, sliding = ranges(found[WITH]), ranges(found[WITHOUT])
    held, text = {}, []
    for name, (symbol, unit) in SYMBOLS.items():
        held[f"that of {symbol} is much larger"] = sliding[name] > MUCH * with_all[name]
        ratio = sliding[name] / with_all[name]
        text.append(f"{symbol} {with_all[name]:.4g} and {sliding[name]:.4g} {unit} ({ratio:.1f} times)")
    return Finding(f"ranges with the non-smooth behaviours and without: {', '.join(text)}", held)


def _sliding(setting: Setting) -> Finding:
    """C22."""
    rest, down = motions.stiff_sweep(False, setting), motions.sliding_downwards(setting)
    periodic = {b: are(b, PERIODIC)[within(b, 1.4, np.inf)] for b in (rest, down)}
    text = (
        f"followed from 3 down {stretches(down)}, periodic at {count(periodic[down])} values from 1.4 on; "
        f"from rest {stretches(rest)}, periodic at {count(periodic[rest])}"
    )
    return Finding(text, {"periodic for all mu_k >= 1.4": bool(periodic[down].all())})


def _nonsmooth(setting: Setting) -> Finding:
    """C23."""
    b = motions.stiff_sweep(True, setting)
    chosen = are(b, NON_PERIODIC)
    held = {"non-periodic for most mu_k": bool(chosen.mean() > 0.5)}
    return Finding(f"{stretches(b)}; non-periodic at {count(chosen)} values", held)


def _onset(setting: Setting) -> Finding:
    """C24."""
    sweeps = {True: motions.stiff_sweep(True, setting), False: motions.sliding_downwards(setting)}
    rest, near = (motions.stiff_sweep(False, setting, start) for start in ("rest", "near"))
    first = {nonsmooth: _first(b) for nonsmooth, b in sweeps.items()}
    ratio = _ratio(sweeps)
    held = {
        "limit cycle from 0.15 with the non-smooth behaviours": bool(np.isclose(first[True], 0.15)),
        "limit cycle from 1.4 without them": bool(np.isclose(first[False], 1.4)),
        "the equilibrium loses stability at 1.735": agrees(critical(), "1.735"),
        "L_s is much larger without them": ratio > MUCH,
    }
    text = (
        f"first at {first[True]:g} with them, from rest; without them at {first[False]:g} followed from 3 "
        f"down, {_first(rest):g} from rest, {_first(near):g} from near the equilibrium; stability lost at "
        f"{critical():.4f}; from 1.4 on L_s is at least {ratio:.1f} times as large without"
    )
    return Finding(text, held)


def _first(b: Any) -> float:
    return float(b.values[moving(b)].min(initial=np.inf))


def _ratio(sweeps: dict[bool, Any]) -> float:
    """The least ratio of the intensities at the values of mu_k from 1.4 on that both sweeps hold."""
    shared, i, j = np.intersect1d(sweeps[False].values, sweeps[True].values, return_indices=True)
    both = shared >= 1.4 - 1e-9
    return float((sweeps[False].intensities[i] / sweeps[True].intensities[j])[both].min())


def _frequencies(setting: Setting) -> Finding:
    """C25."""
    panels = {name: panel(name, setting) for name in LEFT_OUT}
    off = {name: float(np.median(p.deviations)) for name, p in panels.items()}
    close = off["geometry only"]
    held = {
        "they are close with only GN": close < CLOSE,
        "they differ more with only the cubic contact": off["contact stiffness only"] > close,
        "they differ more with only the non-smooth behaviours": off["non-smooth only"] > close,
        "they differ markedly with all three": off["all three"] > CLOSE,
    }
    return Finding("; ".join(f"{name}: {in_words(p)}" for name, p in panels.items()), held)


CHECKS = {
    "C21": Question(
        "Fig. 16",
        "mu_k 2.5, F 800 N, k4 to k6 5e6 N/m: amplitudes are much larger without the non-smooth behaviours",
        _amplitudes,
    ),
    "C22": Question(
        "Fig. 17b",
        "sliding only: periodic for all mu_k >= 1.4 (x1 where its velocity is zero)",
        _sliding,
        impacts=False,
    ),
    "C23": Question("Fig. 17a", "with the non-smooth behaviours: non-periodic for most mu_k", _nonsmooth),
    "C24": Question(
        "Fig. 17c",
        "limit cycle from mu_k 0.15 with the non-smooth behaviours, from 1.4 without; the equilibrium loses "
        "stability at 1.735; L_s much larger without",
        _onset,
    ),
    "C25": Question(
        "Fig. 18",
        "response frequencies against unstable eigenfrequencies: close with only GN; larger differences with "
        "only the cubic contact, or only the non-smooth behaviours; marked with all three",
        _frequencies,
    ),
}
