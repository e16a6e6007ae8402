"""Makes a failing case simple: numbers, law, tolerance, length, one after the other, while it fails alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import frictionlab as fl
from frictionlab.components import FixedLoad
from tests.differential.case import Case
from tests.differential.judge import Verdict, judge

TRIALS = 120  # cases judged in search of a simpler one
SHORTEST = 0.1  # run, in periods of the model


def shrink(
    case: Case, judged: Callable[[Case], Verdict] = judge, trials: int = TRIALS
) -> tuple[Case, Verdict]:
    """The simplest case found that fails in the same kind of way, and its verdict."""
    verdict = judged(case)
    if not verdict.failed:
        raise ValueError(f"the case must fail, got {verdict.kind!r}: {case!r}")
    better = True
    while better and trials > 0:
        better = False
        for simpler in simpler_cases(case):
            if simpler == case:
                continue
            trials -= 1
            other = judged(simpler)
            if other.kind == verdict.kind:
                case, verdict, better = simpler, other, True
                break
            if trials <= 0:
                break
    return case, verdict


def simpler_cases(case: Case) -> Iterator[Case]:
    """Cases that differ in one respect, each simpler than the case, the boldest first."""
    if case.order is not None:
        yield replace(case, order=None)
    if case.tol != 1e-15:
        yield replace(case, tol=1e-15)
    for factor in (0.25, 0.5, 0.8):
        if factor * case.t_end > SHORTEST * case.model.period:
            yield replace(case, t_end=_rounded(factor * case.t_end, 2))
    for model in _models(case.model):
        if len(model.coordinates) == len(case.model.coordinates):
            yield replace(case, model=model)
    for i, x in enumerate(case.x0):
        for value in (0.0, _rounded(x, 1), _rounded(x, 2)):
            if value != x and abs(value) <= abs(x) * 1.5:
                yield replace(case, x0=(*case.x0[:i], value, *case.x0[i + 1 :]))


def _models(model: Any) -> Iterator[Any]:
    if "friction" in model.roles and type(model.friction) is not fl.Coulomb:
        yield _changed(model, friction=fl.Coulomb(mu_k=model.mu_k, mu_s=model.mu_s))
        for kind in (fl.ExponentialDecay, fl.Stribeck):
            if type(model.friction) not in (fl.ExponentialDecay, kind) and "v_s" in model.parameters:
                yield _changed(model, friction=kind(mu_k=model.mu_k, mu_s=model.mu_s, v_s=model.v_s))
    if isinstance(getattr(model, "geometry", None), FixedLoad):
        yield _changed(model, geometry=fl.MovingLoad())
    usual = type(model)().parameters
    for name, value in model.parameters.items():
        none = 0.0 if name.startswith(("c", "mu_")) else value  # no damper, no friction; springs stay
        for other in dict.fromkeys((usual.get(name, value), none, _rounded(value, 1), _rounded(value, 2))):
            if other != value and _digits(other) <= _digits(value):
                yield _changed(model, **{name: other})


def _changed(model: Any, **changes: Any) -> Any:
    """The model with changes; itself where they break a rule."""
    try:
        return model.replace(**changes)
    except ValueError:
        return model


def _rounded(x: float, digits: int) -> float:
    return float(f"{x:.{digits}g}")


def _digits(x: float) -> int:
    return len(f"{x:.17g}".replace("e-0", "").strip("-0.").replace(".", ""))
