"""A structure as data that JSON can hold, in files of sweeps.

Matrices are there with their coefficients, so that the structure that is read has the same parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse

from frictionlab.components.component import Component
from frictionlab.models.kept_structures import is_of_library
from frictionlab.models.serialisation import component_from_dict, component_to_dict
from frictionlab.models.symbolic_laws import law_formulas, symbolic_copy
from frictionlab.structures.parametric_matrix import Matrix, ParametricMatrix
from frictionlab.structures.sliding_contacts import SlidingContacts

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Data = dict[str, Any]
SUMS = ("M", "K", "C", "gyroscopic", "circulatory", "load")
LAWS = ("contact", "friction", "impact")
ROWS = ("normal", "tangential")


def structure_to_data(structure: Structure) -> Data:
    """The matrices, contacts and parameters: equal structures have equal data.

    There are the formulas of laws of one's own: a class may change until the file is read.
    """
    laws = [law for one in structure.contacts for law in (one.contact, one.friction, one.impact) if law]
    own = [symbolic_copy(key) for law in laws if not is_of_library(key := law.structure_key)]
    return {
        "sums": {name: _sum_to_data(getattr(structure, name)) for name in SUMS},
        "contacts": [_contacts_to_data(one) for one in structure.contacts],
        "parameters": dict(structure.parameters),
        "window": structure.window and list(structure.window),
        "units": list(structure.units),
        **({"formulas": str(law_formulas(own))} if own else {}),
    }


def fields_from_data(data: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of the structure that :func:`structure_to_data` described."""
    given: dict[str, Any] = {name: _sum_from_data(one) for name, one in data["sums"].items()}
    if given["load"] is not None:
        given["load"] = [(coefficient, column.toarray().ravel()) for coefficient, column in given["load"]]
    given["contacts"] = [_contacts_from_data(one) for one in data["contacts"]]
    return given | {name: data[name] for name in ("parameters", "window", "units")}


def _sum_to_data(given: Any) -> Any:
    if given is None:
        return None
    if not isinstance(given, ParametricMatrix):  # damping by a law
        return component_to_dict(given)
    terms = zip(given.coefficients, given.matrices, strict=True)
    return [[coefficient, _matrix_to_data(matrix)] for coefficient, matrix in terms]


def _sum_from_data(data: Any) -> Any:
    if data is None:
        return None
    if isinstance(data, Mapping):
        return component_from_dict(data, Component)
    return [(coefficient, _matrix_from_data(matrix)) for coefficient, matrix in data]


def _matrix_to_data(matrix: Matrix) -> Data:
    entries: Any = sparse.csc_array(matrix)
    parts = {"data": entries.data.real, "indices": entries.indices, "indptr": entries.indptr}
    parts |= {"imaginary": entries.data.imag} if entries.dtype.kind == "c" else {}
    return {"shape": list(entries.shape)} | {name: part.tolist() for name, part in parts.items()}


def _matrix_from_data(data: Mapping[str, Any]) -> Matrix:
    entries: Any = np.array(data["data"], dtype=float)
    if "imaginary" in data:
        entries = entries + 1j * np.array(data["imaginary"], dtype=float)
    places = np.array(data["indices"], dtype=int), np.array(data["indptr"])
    return sparse.csc_array((entries, *places), shape=tuple(data["shape"]))


def _contacts_to_data(one: SlidingContacts) -> Data:
    laws = {
        name: None if getattr(one, name) is None else component_to_dict(getattr(one, name)) for name in LAWS
    }
    rows = {
        name: None if getattr(one, name) is None else _matrix_to_data(getattr(one, name)) for name in ROWS
    }
    numbers = {"v": one.v, "N": one.N, "penetration": one.penetration.tolist(), "area": one.area.tolist()}
    return {**rows, **laws, **numbers, "name": one.name}


def _contacts_from_data(data: Mapping[str, Any]) -> SlidingContacts:
    given = dict(data)
    for name in LAWS:
        given[name] = None if data[name] is None else component_from_dict(data[name], Component)
    for name in ROWS:
        given[name] = None if data[name] is None else _matrix_from_data(data[name])
    return SlidingContacts(**given)
