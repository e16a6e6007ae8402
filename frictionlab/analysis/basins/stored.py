"""What a file of basins holds: the schema of its specification and of the results of its tasks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.analysis.basins.attractors import (
    RANGE_RTOL,
    AttractorCatalogue,
    catalogue_of_probes,
)
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.stored_data import (
    array,
    either,
    indices,
    integer,
    listed,
    mapping,
    none_or,
    number,
    record,
    text,
)
from frictionlab.validation import abbreviate, check_choice, check_limits, check_mapping, check_number

MAX_SAMPLES = 10_000_000  # initial states, each of which is a run

SPECIFICATION = record(
    {
        "model": either(str, text(), mapping()),
        "states": listed(text(), distinct=True),
        "coordinates": integer(least=0),
        "count": integer(least=1, most=MAX_SAMPLES),
        "group": integer(least=1, most=MAX_SAMPLES),
        "probes": integer(least=1),
        "starts": text(),
        "transient": number(above=0.0),
        "window": number(above=0.0),
        "rtol": number(above=0.0, below=1.0),
        "tolerance": number(above=0.0),
        "section": none_or(either(str, text(), listed(length=2))),
        "method": record({"name": text()}),
    },
    {
        **{axis: record({"name": text(), "values": array(None)}) for axis in ("x", "y")},
        "ranges": mapping(array(2)),
        "samples": integer(least=1, most=MAX_SAMPLES),
        "seed": integer(least=0),
    },
)


def check_specification(specification: Mapping[str, Any]) -> None:
    """Raise ValueError unless all fields are there, have their types, and agree with each other."""
    SPECIFICATION("", specification)
    states, count = specification["states"], specification["count"]
    check_number("2 coordinates", 2 * specification["coordinates"], most=len(states))
    check_number("probes", specification["probes"], most=count)
    if "x" in specification:
        record({"y": mapping()})("", specification)
        axes = [specification[axis] for axis in "xy"]
        for axis, about in zip("xy", axes):
            check_choice(f"{axis}['name']", about["name"], states)
        check_choice("y['name']", axes[1]["name"], [name for name in states if name != axes[0]["name"]])
        product = len(axes[0]["values"]) * len(axes[1]["values"])
        check_number("count", count, least=product, most=product)
        return
    record({"ranges": mapping(), "samples": integer(), "seed": integer()})("", specification)
    check_mapping("ranges", specification["ranges"], "")
    check_number("the number of ranges", len(specification["ranges"]), least=1)
    for name, limits in specification["ranges"].items():
        check_choice("ranges", name, states)
        check_limits(f"ranges[{abbreviate(name)}]", limits, "")
    check_number("count", count, least=specification["samples"], most=specification["samples"])


def check_results(specification: Mapping[str, Any], results: Mapping[int, Any]) -> None:
    """Raise ValueError unless each result is one that its task returns: of a probe, or of a group."""
    probes, group, count = (specification[name] for name in ("probes", "group", "count"))
    groups = -(-count // group)
    for i, result in results.items():
        check_number("task", i, below=probes + groups)
        if i < probes:
            _check_attractor(f"results[{i}]", result, len(specification["states"]), probe=True)
    first = [i for i in results if i >= probes][:1]
    if first and not all(i in results for i in range(probes)):
        raise ValueError(f"results[{first[0]}] must follow those of all {probes} probes, some are missing")
    known = len(stored_catalogue(specification, results).attractors)
    for i in (i for i in results if i >= probes):
        size = min(group, count - (i - probes) * group)
        _check_group(f"results[{i}]", results[i], known, size, len(specification["states"]))


def _check_attractor(name: str, attractor: Any, states: int, *, probe: bool) -> None:
    record({"kind": text(*MotionKind)})(name, attractor)
    kind, positive = attractor["kind"], number(above=0.0)
    finite = kind != MotionKind.ENDED_EARLY
    fields = {
        "period": positive if kind == MotionKind.PERIODIC else none_or(positive),
        "state": array(states, finite=finite),
    }
    fields |= {"reach": array(2, states, finite=finite)} if probe else {}
    if kind in RANGE_RTOL:
        fields |= {"low": array(states), "high": array(states), "path": array(None, states)}
    record(fields, {"drifting": indices(states)})(name, attractor)


def _check_group(name: str, group: Any, known: int, size: int, states: int) -> None:
    record({"labels": listed(length=size), "found": listed()})(name, group)
    for i, attractor in enumerate(group["found"]):
        _check_attractor(f"{name}['found'][{i}]", attractor, states, probe=False)
    indices(known + len(group["found"]))(f"{name}['labels']", group["labels"])


def stored_catalogue(specification: Mapping[str, Any], results: Mapping[int, Any]) -> AttractorCatalogue:
    """The attractors that the probes led to, each once."""
    probes = [results[i] for i in range(specification["probes"]) if i in results]
    return catalogue_of_probes(probes, specification["coordinates"], specification["rtol"])
