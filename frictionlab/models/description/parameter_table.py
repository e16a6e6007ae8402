"""A model's parameters as a table, in text and in a notebook."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

from frictionlab.models.parameter_namespace import parameter_metadata, parameter_owners


@dataclass(frozen=True)
class ParameterRow:
    """One parameter."""

    name: str
    symbol: str
    value: float
    unit: str
    meaning: str
    owner: str


@dataclass(frozen=True, repr=False)
class ParameterTable:
    """Rows of name, symbol (LaTeX), value, unit, meaning and owner; prints as a table."""

    title: str
    rows: tuple[ParameterRow, ...]

    def __iter__(self) -> Iterator[ParameterRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        lines = [(r.name, f"{r.value:g}", r.unit, r.meaning, r.owner) for r in self.rows]
        table = [("name", "value", "unit", "meaning", "of"), *lines]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        rows = (
            "  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)).rstrip() for line in table
        )
        return "\n".join([self.title, *rows])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{h}</th>" for h in ("symbol", "name", "value", "unit", "meaning", "of"))
        body = "".join(f"<tr>{_html_cells(row)}</tr>" for row in self.rows)
        return f"<p>{escape(self.title)}</p><table><tr>{head}</tr>{body}</table>"


def parameter_table(model: Any) -> ParameterTable:
    """The table of a model's parameters."""
    components = model.components
    about, owner = parameter_metadata(type(model), components), parameter_owners(type(model), components)
    names = {"": "structure"} | {role: type(component).__name__ for role, component in components.items()}
    rows = (
        ParameterRow(
            name, about[name].symbol, value, about[name].unit, about[name].meaning, names[owner[name]]
        )
        for name, value in model.parameters.items()
    )
    laws = ", ".join(f"{role} {type(component).__name__}" for role, component in components.items())
    return ParameterTable(f"{type(model).__name__}: {laws}", tuple(rows))


def _html_cells(row: ParameterRow) -> str:
    texts = (row.name, f"{row.value:g}", row.unit, row.meaning, row.owner)
    return f"<td>${escape(row.symbol)}$</td>" + "".join(f"<td>{escape(text)}</td>" for text in texts)
