"""The sliders, switches and presets of a page, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from frictionlab.components.component import Parameter
from frictionlab.models import Model
from frictionlab.models.composition import parameter_metadata
from frictionlab.validation import check_mapping, check_number, did_you_mean_or_known

OPEN_SLIDERS = 8  # shown at first where none are chosen; the others are one click away
STEPS = 400  # of a slider from one end to the other


def switch_names(model: Model, switches: Sequence[str] | None) -> tuple[str, ...]:
    """The nonlinearities that have a switch; those that the model is without already have none."""
    known = {name: each for name, each in model.nonlinearities.items() if not each.missing(model)}
    if switches is None:
        return tuple(name for name in known if _can_be_switched(model, name))
    for name in switches:
        if name not in known:
            raise ValueError(
                f"switches has no nonlinearity {name!r}{did_you_mean_or_known(name, list(known))}"
            )
    return tuple(switches)


def _can_be_switched(model: Model, name: str) -> bool:
    try:
        model.without(name)
    except ValueError:  # a law that cannot do without its nonlinearity
        return False
    return True


def structures(model: Model, switches: Sequence[str]) -> dict[str, Model]:
    """The model without every combination of the switches, by their names joined with commas."""
    sets = [some for k in range(len(switches) + 1) for some in combinations(switches, k)]
    return {",".join(some): model.without(*some) if some else model for some in sets}


def slider_data(model: Model, sliders: Mapping[str, Any] | Sequence[str] | None) -> list[dict[str, Any]]:
    """One entry for each parameter: name, symbol, unit, meaning, range; `open` where it is shown at first."""
    about = parameter_metadata(type(model), model.components)
    names = list(model.parameters)
    chosen = _default_sliders(model) if sliders is None else list(sliders)
    ranges = sliders if isinstance(sliders, Mapping) else {}
    for name in chosen:
        if name not in names:
            raise ValueError(f"sliders has no parameter {name!r}{did_you_mean_or_known(str(name), names)}")
    ordered = [*chosen, *(name for name in names if name not in chosen)]
    return [
        _slider(name, about[name], model.parameters[name], ranges.get(name)) | {"open": name in chosen}
        for name in ordered
    ]


def _default_sliders(model: Model) -> list[str]:
    """Parameters of the laws first, as the motion depends on them most."""
    own = set(parameter_metadata(type(model), {}))
    laws = [name for name in model.parameters if name not in own]
    first = [name for name in ("mu_k", "mu_s", "F", "v", "k_nl", "k2", "Omega") if name in model.parameters]
    return list(dict.fromkeys([*first, *laws, *model.parameters]))[:OPEN_SLIDERS]


def _slider(name: str, about: Parameter, value: float, bounds: Any) -> dict[str, Any]:
    low, high = _range(name, about, value, bounds)
    return {
        "name": name,
        "symbol": about.symbol,
        "unit": about.unit,
        "meaning": about.meaning,
        "value": float(value),
        "low": low,
        "high": high,
        "log": bool(about.log and low > 0),
    }


def _range(name: str, about: Parameter, value: float, bounds: Any) -> tuple[float, float]:
    if bounds is not None:
        low, high = bounds
        check_number(f"the low end of slider {name!r}", low, cure="give (low, high)")
        check_number(f"the high end of slider {name!r}", high, above=low, cure="give (low, high)")
    elif about.range is not None:
        low, high = about.range
    else:
        twice = 2 * abs(value) or 1.0
        low, high = (0.0 if about.minimum is not None else -twice), twice
    if about.log and low <= 0 < value and bounds is None:
        low = min(value, high) / 1e3
    return float(min(low, value)), float(max(high, value))


def preset_data(model: Model, switches: Sequence[str], presets: Any) -> list[dict[str, Any]]:
    """Names with values of parameters and, as ``without``, the switches that are off."""
    check_mapping("presets", presets or {}, 'give each a name, such as {"flutter": {"mu_k": 1.4}}')
    return [_preset(model, switches, name, values) for name, values in (presets or {}).items()]


def _preset(model: Model, switches: Sequence[str], name: str, values: Any) -> dict[str, Any]:
    check_mapping(f"presets[{name!r}]", values, 'give values, such as {"mu_k": 1.4}')
    values = dict(values)
    off = values.pop("without", ())
    off = [off] if isinstance(off, str) else list(off)
    for switch in off:
        if switch not in switches:
            raise ValueError(
                f"presets[{name!r}] has no switch {switch!r}{did_you_mean_or_known(switch, list(switches))}"
            )
    model.replace(**values)  # raises for unknown names and values that break a rule
    return {"name": name, "values": {key: float(value) for key, value in values.items()}, "without": off}
