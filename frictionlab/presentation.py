"""How results are shown: as short text, as tables of pandas and xarray, in Markdown, and as pictures.

Also the mapping in which results hold values by name.  pandas and xarray come with the extra ``data`` and are
imported when a table is asked for.  Tables carry units: a DataFrame in ``attrs["units"]``, a Dataset in
``attrs["units"]`` of each variable.  All attributes are what Parquet and netCDF files can hold.  The analyses
do not import `frictionlab.plotting`, which draws their results; only `Drawable` does, when it draws.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import StrEnum
from html import escape
from importlib import import_module
from importlib.util import find_spec
from typing import Any, ClassVar, Generic, TypeVar

from frictionlab.letters import ANGLE_LETTERS

Value = TypeVar("Value")
MAX_LISTED = 8  # items that a summary names before it says how many more there are
MAX_ROWS = 10  # rows of a table in text
MAX_COLUMNS = 12  # columns of a table in a notebook
MAX_ROW_LENGTH = 110  # characters of such a row
OUTPUT_UNITS = {
    "penetration": "m",
    "gap": "m",
    "distance": "m",
    "normal_force": "N",
    "friction_force": "N",
    "reaction": "N",
    "relative_velocity": "m/s",
    **{f"friction_force_{one}": "N" for one in "ab"},  # the components of friction in the plane
    **{f"relative_velocity_{one}": "m/s" for one in "ab"},
}
SI = "m", "N"  # units of length and of force
ROTATIONAL_UNITS = {"m": "rad", "m/s": "rad/s", "s/m": "s/rad", "1/m": "1/rad", "N": "N m", "N s/m": "N m s"}
STIFFNESS_UNIT = re.compile(r"N/m(\^[\d.]+)?")  # also of a force that is a power of the penetration
FORCE_SYMBOLS = {"normal_force": "F_N", "reaction": "F_N", "friction_force": "F_T"}
DISTANCE = "distance"  # begins the names of the outputs of how far open rigid contacts are
REACTION = "reaction"  # begins the names of the outputs of rigid contacts
WEDGE = "wedge"  # begins the names of events at which a rigid contact that rubs loses its reaction
TIME = "t"  # the state of models that depend on time otherwise, s
PHASE = "phase"  # the state that stands for time in models with a periodic force, rad
BACKWARDS = (
    f"frequency, the rate of {PHASE!r}, must be at least 0, got {{rate}}{{at}}: give it without the sign, "
    f"and write -{PHASE} for {PHASE} where the load runs backwards"
)


class FrozenMapping(Mapping[str, Value], Generic[Value]):
    """A read-only mapping of names to what results hold; equal to a dictionary of the same items."""

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, Value]) -> None:
        self._items = dict(items)

    def __getitem__(self, name: str) -> Value:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenMapping, (self._items,)

    def __repr__(self) -> str:
        return repr(self._items)


class OwnUnits:
    """Base of what names its units of length and of force; `units` of a model is a field as any other."""

    units: Any = SI


class Kind(StrEnum):
    """Base of kinds: each member equals its text, and is shown as that text in results."""

    def __repr__(self) -> str:
        return repr(self.value)


def is_angle(name: str) -> bool:
    """Whether a coordinate, or its rate, is an angle by its name: phi, theta, psi, alpha, phi1, phi_M ..."""
    return name.rstrip("'").partition("_")[0].rstrip("0123456789") in ANGLE_LETTERS


def state_unit(name: str) -> str:
    """SI unit of a coordinate or of its rate."""
    if name == TIME:
        return "s"
    length = "rad" if is_angle(name) or name == PHASE else "m"
    return f"{length}/s" if name.endswith("'") else length


def unit_of_state(source: Any, name: str) -> str:
    """SI unit of a coordinate of a model or structure, of its rate, of time and of a phase.

    "" of further states, such as a current, and where `source` is None or an automaton, unless it has the
    units of a structure: nothing tells theirs.
    """
    coordinates = getattr(source, "coordinates", 0)
    if isinstance(coordinates, int):
        coordinates = getattr(source, "shown_states", ()) if isinstance(source, OwnUnits) else None
    if coordinates is None or name.removesuffix("'") not in (*coordinates, TIME, PHASE):
        return ""
    return in_units_of(source, state_unit(name))


def output_of_contact(name: str) -> tuple[str, str]:
    """An output's name without the number of its contact, and that number: normal_force_2, normal_force."""
    base, _, number = name.rpartition("_")
    return (base, number) if number.isdigit() else (name, "")


def output_unit(name: str, source: Any) -> str:
    """Unit of an output, also of one of several contacts (normal_force_2); "" where it is not known."""
    unit = OUTPUT_UNITS.get(output_of_contact(name)[0], "")
    return rotational_unit(unit) if is_rotational(name, source) else in_units_of(source, unit)


def impulse_unit(name: str, source: Any) -> str:
    """Unit of an impulse of a run's events: that of the contact's force or moment, times s."""
    rubs, _, number = name.rpartition("impulse")
    forces = ("friction_force",) if rubs else ("normal_force", "reaction")
    turning = any(is_rotational(force + number, source) for force in forces)
    return "N m s" if turning else in_units_of(source, "N s")


def rotational_unit(unit: str) -> str:
    """Unit at a contact whose bodies turn, by that at one whose bodies slide: N m for N, rad for m.

    Radians are left out of stiffnesses and dampers.  Any other unit is returned as it is.

    >>> rotational_unit("m/s"), rotational_unit("N/m^2"), rotational_unit("K")
    ('rad/s', 'N m', 'K')
    """
    return "N m" if STIFFNESS_UNIT.fullmatch(unit) else ROTATIONAL_UNITS.get(unit, unit)


def force_symbol(name: str, source: Any) -> str:
    """Symbol of a contact force: F_N, F_T, F_{N,2} ... or, where the bodies turn, of a moment: M_N, M_T."""
    base, number = output_of_contact(name)
    letter, index = FORCE_SYMBOLS[base].split("_")
    letter = "M" if is_rotational(name, source) else letter
    return f"{letter}_{{{index},{number}}}" if number else f"{letter}_{index}"


def is_rotational(name: str, source: Any) -> bool:
    """Whether an output of a model is of a contact whose bodies turn: an angle, its rate or a moment."""
    return name in getattr(source, "rotational_outputs", ())


def in_units_of(source: Any, text: str) -> str:
    """A unit of SI, or a text that ends with one in brackets, in a structure's units of length and force."""
    return in_units(source.units if isinstance(source, OwnUnits) else SI, text)


def in_units(units: Sequence[str], text: str) -> str:
    """As :func:`in_units_of`, by the units of length and force themselves."""
    length, force = units
    if (length, force) == SI:
        return text
    own = {"m": length, "N": force, "J": f"{force} {length}", "W": f"{force} {length}/s"}
    words, bracket, unit = text.rpartition("(")
    return words + bracket + re.sub(r"\b[mNJW](?![^\W²])", lambda match: own[match[0]], unit)


def shorten(items: Iterable[str], most: int = MAX_LISTED, separator: str = ", ") -> str:
    """The first items, and how many more there are."""
    listed = list(items)
    more = f", and {len(listed) - most} more" if len(listed) > most else ""
    return separator.join(listed[:most]) + more


def count(number: int, noun: str) -> str:
    """A number with its noun in the singular or plural."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def tally(names: Iterable[Any]) -> str:
    """How often each name occurs, the most frequent first."""
    return shorten(f"{count} {name}" for name, count in Counter(map(str, names)).most_common())


def span(values: Any) -> str:
    """The range of the finite values as text, from the smallest to the largest."""
    finite = [float(value) for value in values if abs(value) < float("inf")]
    if not finite:
        return "none"
    low, high = min(finite), max(finite)
    return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"


def text_table(rows: Iterable[str], most: int = MAX_ROWS) -> str:
    """The first rows of a table as text, each cut to one line of limited length."""
    lines = [" ".join(row.split("\n")).rstrip() for row in rows]
    shown = [row if len(row) <= MAX_ROW_LENGTH else f"{row[: MAX_ROW_LENGTH - 3]}..." for row in lines[:most]]
    return "\n".join([*shown, f"... and {len(lines) - most} more"] if len(lines) > most else shown)


def import_optional(package: str, what: str, extra: str = "data") -> Any:
    """Import a package that comes with an extra.

    Raises
    ------
    ImportError
        Where it is not installed, with the command that installs it.
    """
    try:
        return import_module(package)
    except ImportError as error:
        raise ImportError(f"{what} needs {package}: pip install 'frictionlab[{extra}]'") from error


def dataframe(columns: Mapping[str, Any], index: Mapping[str, Any], units: Mapping[str, str]) -> Any:
    """A pandas DataFrame of columns (N,), with one or more columns as its index.

    Parameters
    ----------
    columns, index : mapping of str to array (N,)
    units : mapping of str to str
        Of columns and index; those without a unit may be missing.
    """
    pd = import_optional("pandas", "to_dataframe")
    (name, values), *others = index.items()
    rows = pd.MultiIndex.from_arrays(list(index.values()), names=list(index)) if others else None
    table = pd.DataFrame(dict(columns), index=pd.Index(values, name=name) if rows is None else rows)
    table.attrs["units"] = {name: units[name] for name in (*index, *columns) if units.get(name)}
    return table


def dataset(
    variables: Mapping[str, tuple[Any, Any]],
    coordinates: Mapping[str, Any],
    units: Mapping[str, str],
    attributes: Mapping[str, Any] | None = None,
) -> Any:
    """An xarray Dataset, its variables and coordinates with their units.

    Parameters
    ----------
    variables : mapping of str to (dimensions, array)
    coordinates : mapping of str to array
    units : mapping of str to str
        Those without a unit may be missing.
    attributes : mapping of str to number or str
    """
    xr = import_optional("xarray", "to_xarray")
    table = xr.Dataset(dict(variables), dict(coordinates), dict(attributes or {}))
    for name in table.variables:
        if units.get(str(name)):
            table[name].attrs["units"] = units[str(name)]
    return table


def html_rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts as HTML."""
    tagged = [("th", head), *(("td", row) for row in rows)]
    lines = ("".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row) for tag, row in tagged)
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def html_table(table: Any) -> str:
    """The first rows of a DataFrame as HTML, with the units of its columns and how many rows it has."""
    units = table.attrs.get("units", {})

    def with_unit(name: Any) -> str:
        return f"{name} ({units[name]})" if units.get(name) else str(name or "")

    head = table.head(MAX_ROWS).rename(columns=with_unit)
    head.index.names = [with_unit(name) for name in head.index.names]
    more = f"<p>{len(table)} rows</p>" if len(table) > MAX_ROWS else ""
    return str(head.to_html(float_format="{:.5g}".format, max_cols=MAX_COLUMNS)) + more


class Drawable:
    """A result that a function of ``frictionlab.plotting`` draws."""

    drawn_by: ClassVar[str]  # the name of that function
    instead_of_array: ClassVar[str] = ""  # what to write where numpy is asked to make an array of it
    several_axes: ClassVar[bool] = False  # whether that function may make several axes, and returns them

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        """Refuse to be taken for numbers, of which numpy would make an object with no shape.

        An element of an array of objects it may be.
        """
        import numpy as np

        if dtype is not None and np.dtype(dtype).hasobject:
            element = np.empty((), dtype=object)
            element[()] = self
            return element
        name = type(self).__name__
        tables = [f"write {table}()" for table in ("to_array", "to_dataframe") if hasattr(self, table)]
        cure = self.instead_of_array or next(iter(tables), f"see the attributes of {name}")
        raise TypeError(f"numpy cannot make an array of {name}: {cure}")

    def _repr_html_(self) -> str:
        """What a notebook shows: the summary, and the first rows of the table where there is one."""
        text = f"<p>{escape(repr(self))}</p>"
        table: Any = getattr(self, "to_dataframe", None)
        return text if table is None or find_spec("pandas") is None else text + html_table(table())

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the result by the function of ``frictionlab.plotting`` that `drawn_by` names.

        Parameters
        ----------
        ax : Axes or None
            None draws into a new figure, with a legend where several things are labelled.
        **options
            Further keywords of that function.

        Returns
        -------
        Axes
            Those drawn into, the first where there are several; a notebook shows the picture.
        """
        from frictionlab import plotting

        draw = getattr(plotting, self.drawn_by)
        if self.several_axes:
            axes = draw(self, ax, **options)[0]
        else:
            axes = plotting.axes_or_new(ax)
            draw(self, axes, **options)
        if ax is None and options.get("legend", True):
            plotting.add_missing_legend(axes.figure)
        return axes
