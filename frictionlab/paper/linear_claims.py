"""Claims C1 to C8, on equilibria and linear stability."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from frictionlab.models import SliderOnBelt
from frictionlab.stability import CriticalCurve, eigenvalues, equilibrium, stability_changes

from .claims import Claim, verdict
from .coalescence import MU_K, PRELOADS, Coalescence, coalescence
from .critical import WITH, WITHOUT, at_preload, by_geometry, by_stiffness, jumps_of
from .pairs import in_words
from .printed import agrees, listed
from .two_pairs import two_pairs

EQUILIBRIA = {
    "C1": (0.3, "-0.0042 -0.0304 -0.0036 -0.0061 -0.0001"),
    "C2": (1.4, "-0.0053 -0.0263 -0.0147 -0.0053 0.0026"),
    "C3": (2.5, "0.0124 -0.0233 -0.0232 -0.0046 0.0041"),
}
ERRATA = {"C2": "E1: x1 has the other sign; with -0.0053 its static equation is not satisfied"}
# Growth rate and angular frequency of the two coupled modes at mu_k.
EIGENVALUES = {
    0.3: (("-0.05", "100"), ("-0.04", "89.4")),
    1.4: (("-0.05", "98.7"), ("-0.048", "93.7")),
    2.5: (("11.98", "102.6"), ("-12.08", "102.6")),
}
MET = 0.02  # share of their first distance to which two frequencies that coalesce come together


def _equilibrium(name: str) -> Claim:
    mu_k, text = EQUILIBRIA[name]
    printed, q = text.split(), equilibrium(SliderOnBelt(mu_k=mu_k)).q
    found = verdict(*(agrees(value, number) for value, number in zip(q, printed)))
    says = f"equilibrium at mu_k {mu_k:g}: [{', '.join(printed)}] m, rad"
    return Claim(name, "4.2.1", says, listed(q, 6), found, ERRATA.get(name, ""))


def _eigenvalues() -> Claim:
    """C4."""
    says = "; ".join(f"{', '.join(map(_pair, pairs))} ({mu_k:g})" for mu_k, pairs in EIGENVALUES.items())
    held, computed = [], []
    for mu_k, pairs in EIGENVALUES.items():
        values = eigenvalues(SliderOnBelt(mu_k=mu_k)).values
        nearest = [values[np.abs(values - complex(*map(float, p))).argmin()] for p in pairs]
        held += [agrees(v.real, p[0]) and agrees(v.imag, p[1]) for v, p in zip(nearest, pairs)]
        shown = (_pair((f"{v.real:.4f}", f"{v.imag:.3f}")) for v in nearest)
        computed.append(f"{', '.join(shown)} ({mu_k:g})")
    return Claim(
        "C4", "4.2.1", f"eigenvalues of the coupled modes: {says}", "; ".join(computed), verdict(*held)
    )


def _pair(parts: tuple[str, str]) -> str:
    return f"{parts[0]} ± {parts[1]}i"


def _coalescence() -> Claim:
    """C5."""
    held, computed, others = [], [], []
    for preload in PRELOADS.values():
        data = coalescence(preload)
        critical = [changes[0].value for changes in data.changes.values()]
        held += [_couples(data, k) for k in data.loci] + (np.diff(critical) < 0).tolist()
        computed.append(f"{', '.join(f'{c:.4f}' for c in critical)} at F = {preload:g} N")
        others += [f"F = {preload:g} N: {in_words(c[1:])}" for c in data.changes.values() if len(c) > 1]
    says = (
        "two frequencies coalesce and one growth rate turns positive as mu_k grows; "
        "a larger k_nl gives a smaller critical mu_k (F = 100 N and 1000 N)"
    )
    stiffnesses = ", ".join(f"{k:g}" for k in data.loci)
    text = f"critical mu_k for k_nl = {stiffnesses} N/m^3: {'; '.join(computed)}"
    note = f"for the largest k_nl a third mode grows as well: {'; '.join(others)}" if others else ""
    return Claim("C5", "Figs 2, 3", says, text, verdict(*held), note)


def _couples(data: Coalescence, k_nl: float) -> bool:
    """Whether the frequencies of the pair meet, and one of its growth rates turns positive there."""
    locus, pair = data.loci[k_nl], list(data.pairs[k_nl])
    apart = np.abs(np.diff(locus.frequencies[:, pair], axis=1))[:, 0]
    beyond = locus.at > data.changes[k_nl][0].value
    growing = locus.growth_rates[:, pair] > 0
    turned = not growing[~beyond].any() and (growing[beyond].sum(axis=1) == 1).all()
    return bool(turned and apart[beyond].min() < MET * apart[0])


def _falls() -> Claim:
    """C6."""
    curves = by_stiffness().curves
    rises = {k: _rises(curve) for k, curve in curves.items()}
    computed = "; ".join(f"k_nl = {k:g} N/m^3: {_range(curve)}" for k, curve in curves.items())
    notes = [f"k_nl = {k:g} N/m^3: rises from {', '.join(where)}" for k, where in rises.items() if where]
    falling = [step < 0 for curve in curves.values() for step in np.diff(curve.values)]
    says = "the critical mu_k falls as the preload grows, for each k_nl"
    return Claim("C6", "Fig. 4", says, computed, verdict(*falling), "; ".join(notes))


def _rises(curve: CriticalCurve) -> list[str]:
    """Where the critical value grows with the preload, run by run; at a jump, all that happens with mu_k."""
    up = np.concatenate([[0], np.diff(curve.values) >= 0, [0]])
    runs = zip(np.flatnonzero(np.diff(up) == 1).tolist(), np.flatnonzero(np.diff(up) == -1).tolist())
    return [f"{_range(curve, first, last)}{_jumped(curve, first, last)}" for first, last in runs]


def _jumped(curve: CriticalCurve, first: int, last: int) -> str:
    jumps = [i for i in jumps_of(curve) if first <= i < last]
    if not jumps:
        return ""
    at = float(curve.at[jumps[0]])
    changes = stability_changes(curve.model.replace(F=at), "mu_k", MU_K)
    return f" (at F = {at:.4g} N: {in_words(changes)})"


def _range(curve: CriticalCurve, first: int = 0, last: int = -1) -> str:
    return f"{at_preload(curve, first)} to {at_preload(curve, last)}"


def _geometry() -> Claim:
    """C7."""
    curves = by_geometry().curves
    at, i, j = np.intersect1d(curves[WITH].at, curves[WITHOUT].at, return_indices=True)
    less = curves[WITHOUT].values[j] - curves[WITH].values[i]
    computed = f"smaller by up to {less.max():.4f} (F = {at[less.argmax()]:.4g} N)"
    note = ""
    if (less <= 0).any():
        computed += f", at every F computed above {at[less <= 0].max():.4g} N"
        note = (
            f"at smaller F it is larger with GN, by up to {-less.min():.4f} (F = {at[less.argmin()]:.4g} N)"
        )
    says = "the critical mu_k is smaller with GN than without, at every preload"
    return Claim("C7", "Fig. 5", says, computed, verdict(*(less > 0)), note)


def _two_pairs() -> Claim:
    """C8."""
    changes = two_pairs().changes
    counts = {name: [0, *(c.unstable[1] for c in found)] for name, found in changes.items()}
    held = counts[WITH] == [0, 1, 2, 1], counts[WITHOUT] == [0, 1]
    computed = "; ".join(f"{name} {in_words(found)}" for name, found in changes.items())
    says = (
        "F = 1000 N, l1 = 0.1 m, l2 = 0.3 m: with GN two pairs are unstable over a range of mu_k, "
        "one of them stable again for larger mu_k; without GN only one ever is unstable"
    )
    return Claim("C8", "Fig. 6", says, computed, verdict(*held))


CHECKS: dict[str, Callable[[], Claim]] = {
    **{name: partial(_equilibrium, name) for name in EQUILIBRIA},
    "C4": _eigenvalues,
    "C5": _coalescence,
    "C6": _falls,
    "C7": _geometry,
    "C8": _two_pairs,
}
