"""What `frictionlab run` prints: plain ASCII, so that every terminal shows it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any


def before(model: Any, method: Any, chosen: argparse.Namespace) -> str:
    """What is run, and what is known without running it."""
    return "\n".join([_job(model, method, chosen), *_sliding(model)])


def after(run: Any) -> str:
    """What the run gave."""
    return "\n".join([f"\nRun: {run.status}", *_events(run), *_times(run), _cost(run)])


def _job(model: Any, method: Any, chosen: argparse.Namespace) -> str:
    start = {"rest": "from rest", "near": "from near the equilibrium"}.get(chosen.x0, f"from {chosen.x0}")
    return f"{model!r}\n{chosen.t_end:g} s {start}, {_settings(method)}"


def _settings(method: Any) -> str:
    about = method.describe()
    name = about.get("integrator", about["name"])
    return f"method {name}, " + ", ".join(f"{k} {about[k]:g}" for k in ("tol", "step", "rtol") if k in about)


def _sliding(model: Any) -> Iterator[str]:
    """Equilibrium and eigenvalues, or one line that says why there are none."""
    from frictionlab.stability import equilibrium

    try:
        point = equilibrium(model)
        yield "\nSliding equilibrium"
        for name, value in zip(model.coordinates, point.q, strict=True):
            yield f"  {name:4} {value:+.6f} {'rad' if name == 'phi' else 'm'}"
        forces = f"F_N {point.normal_force:.4f} N, F_T {point.friction_force:.4f} N"
        yield f"  gap  {point.gap:+.6f} m, {forces}"
        yield from _eigenvalues(model)
    except ValueError as error:
        yield f"\nNo sliding equilibrium: {error}"


def _eigenvalues(model: Any) -> Iterator[str]:
    from frictionlab.stability import eigenvalues

    try:
        found = eigenvalues(model)
    except ValueError as error:
        yield f"\nNo eigenvalues: {error}"
        return
    lasting = f"{sum(found.growth_rates >= 0)} do not decay"
    kind = "stable" if found.stable else "marginal" if found.marginal else "unstable"
    verdict = kind if found.stable else f"{kind}: {lasting}"
    yield f"\nEigenvalues there ({verdict})\n  frequency (Hz)  growth rate (1/s)  value (1/s)"
    # Of a conjugate pair the one in the upper half-plane stands for both.
    for value, frequency in zip(found.values, found.frequencies, strict=True):
        if value.imag >= 0:
            pair = f" +- {value.imag:.4f}i" if value.imag else ""
            yield f"  {frequency:14.4f}  {value.real:+17.5f}  {value.real:+.5f}{pair}"


def _events(run: Any) -> Iterator[str]:
    yield f"Events: {run.stats['events']}, accumulations closed: {run.stats['accumulations']}"
    counts = run.events.counts()
    width = max(map(len, counts), default=0)
    for kind, count in counts.items():
        yield f"  {kind:{width}}  {count:7d}"


def _times(run: Any) -> Iterator[str]:
    total = sum(run.time_in_mode.values())
    shares = (f"{name} {100 * seconds / (total or 1):.2f} %" for name, seconds in run.time_in_mode.items())
    yield f"Time: {', '.join(shares)}"


def _cost(run: Any) -> str:
    return (
        f"Computed {run.raw.t:g} s in {run.stats['steps']} steps, {run.stats['wall_time']:.3g} s of wall time"
    )
