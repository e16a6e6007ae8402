"""`fl.Structure`: the matrices of a structure of many freedoms, as finite-element programs export them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from html import escape
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

from frictionlab.automaton import HybridAutomaton
from frictionlab.models.mechanical.law_states_at_start import StatesOfLaws
from frictionlab.models.mechanical.mechanics import names_of_law_states
from frictionlab.models.model import check_parameter_name
from frictionlab.presentation import SI, OwnUnits, count, shorten
from frictionlab.stability.boundaries.stability_changes import StabilityChange
from frictionlab.stability.eigenproblems.root_locus import RootLocus
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium
from frictionlab.stability.large_system import LargeSystem, SpectraOf
from frictionlab.structures.damping import RayleighDamping
from frictionlab.structures.energy_balance import StructureBalance
from frictionlab.structures.matrix_files import read_matrices
from frictionlab.structures.parametric_matrix import (
    SHOWN,
    Matrix,
    ParametricMatrix,
    check_symmetry,
    parametric_matrix,
    parametric_vector,
    paths_in,
)
from frictionlab.structures.quadratic_pencil import QuadraticPencil, factorised
from frictionlab.structures.sliding_contacts import COMPLEX_STEP, ContactForces, SlidingContacts, StateRows
from frictionlab.structures.sliding_equilibrium import Statics, equilibrium_of, newton_of_many
from frictionlab.structures.structure_data import fields_from_data, structure_to_data
from frictionlab.structures.window_eigenvalues import MOST_DENSE, WindowEigenvalues, window_eigenvalues
from frictionlab.validation import (
    abbreviate,
    check_limits,
    check_mapping,
    check_number,
    check_sequence,
    explains_fields,
    unknown_parameter,
)

Array = NDArray[np.float64]
OWNERS = ("C", "contacts")  # fields that may have parameters of their own
MATRICES = ("M", "K", "C", "gyroscopic", "circulatory")
REQUIRED = ("M", "K")
INDEFINITE_SHARE = 1e-10  # of the largest eigenvalue of a scaled mass matrix: rounding leaves so much
USUAL_PERIOD = 0.1  # s
NEAR = 0.01  # of the size at which a mode's motion meets an event
SAME_EIGENVALUE = 1e-6  # share by which an eigenvalue may differ between the state matrix and the pencil
LANCZOS_TOL = 1e-3  # of the smallest eigenvalue of a mass matrix, of which only the sign matters


@explains_fields
@dataclass(frozen=True, eq=False, repr=False)
class Structure(LargeSystem[WindowEigenvalues], OwnUnits):
    """M q'' + (C + G) q' + (K + N) q = load + forces of contacts, a structure with n freedoms.

    It moves little about a state in which all contacts slide steadily, or are open.

    Each matrix is an array, a sparse matrix of scipy, the path of a file (see :func:`read_matrix`), a
    function of named parameters, such as ``lambda r: D + r*G + (1/r - 1)*R``, or a sum: a list of
    (coefficient, matrix).  A coefficient is a number, a text such as "1/r - 1", or a function of named
    parameters.  Functions are called once, with formulas in place of numbers, and give the sum that they
    compute.  New values of parameters read and check no matrix again.

    Matrices are used as they are.  One that is not what it must be is refused.

    Parameters
    ----------
    M : matrix (n, n)
        Mass: symmetric, not negative.  Freedoms without mass are held by stiffness or damping.
    K : matrix (n, n)
        Stiffness: symmetric.  Complex where damping is hysteretic, as K (1 + i eta); then only eigenvalues
        with Im >= 0 mean anything.
    C : matrix (n, n) or RayleighDamping, optional
        Damping: symmetric.
    gyroscopic : matrix (n, n), optional
        G, skew: what rotation adds to the damping.
    circulatory : matrix (n, n), optional
        N, of any form: what friction adds to the stiffness.
    load : array (n,), optional
        Constant forces, a function, or a sum: a list of (coefficient, array).  Without contacts they matter
        to the static displacements alone.
    contacts : SlidingContacts or sequence of SlidingContacts, optional
        With their laws.  What they add to K and C is that of the equilibrium under the load.
    parameters : mapping of str to float, optional
        Values of the parameters that coefficients name.
    window : (float, float), optional
        Frequencies of interest, Hz.  It may be left out up to 400 freedoms, where all eigenvalues are found.
    units : (str, str)
        Of length and force, as results and figures show them: ("mm", "N") where matrices are in mm, t and s.
        They convert nothing.  The time is in s.

    Raises
    ------
    ValueError
        For a matrix that is not square or finite, of another size than the others, or without the symmetry
        that it must have; a mass matrix that is not positive; a parameter without a value, or without use; a
        function that computes no sum of expressions times matrices.

    See Also
    --------
    frictionlab.eigenvalues, frictionlab.root_locus, frictionlab.critical_value, frictionlab.equilibrium

    Examples
    --------
    Two modes that friction couples (Hoffmann et al. 2002): it is unstable above mu = 1/2.

    >>> import numpy as np
    >>> import frictionlab as fl
    >>> structure = fl.Structure(
    ...     M=[[1.0, 0.0], [0.0, 1.0]],
    ...     K=[[2.0, 0.0], [0.0, 1.0]],
    ...     circulatory=lambda mu: mu * np.array([[0.0, 1.0], [-1.0, 0.0]]),
    ...     parameters={"mu": 0.6},
    ... )
    >>> structure
    Structure(2 freedoms, mu=0.6)
    >>> fl.eigenvalues(structure).stable
    False
    >>> round(fl.critical_value(structure, "mu", (0, 1)), 8)
    0.5
    """

    M: Any
    K: Any
    C: Any = None
    gyroscopic: Any = None
    circulatory: Any = None
    load: Any = None
    contacts: Any = None
    parameters: Any = None
    window: Any = None
    units: Any = SI

    def __post_init__(self) -> None:
        object.__setattr__(self, "contacts", self._checked_contacts())
        object.__setattr__(self, "parameters", self._checked_parameters())
        files = read_matrices(path for name in MATRICES for path in paths_in(getattr(self, name)))
        new = []
        for name in MATRICES:
            given = getattr(self, name)
            if given is None and name not in REQUIRED:
                continue
            if isinstance(given, ParametricMatrix) or (name == "C" and isinstance(given, RayleighDamping)):
                continue
            object.__setattr__(self, name, parametric_matrix(name, given, self.parameters, files))
            new.append(name)
        if self.load is not None and not isinstance(self.load, ParametricMatrix):
            object.__setattr__(self, "load", parametric_vector(self.load, self.parameters, self.size))
        self._check_sizes()
        self._check_names_of_law_states()
        self._check_use_of_parameters()
        self._check_symmetries(new)
        self._check_mass("M" in new)
        self._check_units()
        if self.window is not None:
            cure = "give (low, high) in Hz, such as (0, 8000)"
            low, high = check_limits("window", self.window, cure)
            check_number("the lower end of window", low, least=0.0, cure=cure)
            object.__setattr__(self, "window", (low, high))
        elif self.size > MOST_DENSE:
            raise ValueError(
                f"window must be given for more than {MOST_DENSE} freedoms, got None for {self.size}: give "
                "the range of frequencies in Hz, such as window=(0, 8000)"
            )

    @property
    def size(self) -> int:
        """The number n of freedoms."""
        return self.M.size

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the freedoms: q0, q1, ..."""
        return tuple(f"q{i}" for i in range(self.size))

    @cached_property
    def massless(self) -> tuple[int, ...]:
        """Freedoms without mass, whose rows of M are zero."""
        return tuple(map(int, np.flatnonzero(_largest_in_rows(self.M.at(self.parameters)) == 0.0)))

    @cached_property
    def pencil(self) -> QuadraticPencil:
        """M, C + G and K + N at the values of the parameters, with what contacts add at the equilibrium."""
        return self.with_contacts(self.structural_pencil, self.contact_forces)

    @cached_property
    def structural_pencil(self) -> QuadraticPencil:
        """M, C + G and K + N without the contacts."""
        return self._pencil(lambda one: one.at(self.parameters))

    @property
    def load_vector(self) -> Array:
        """The constant forces (n,)."""
        if self.load is None:
            return np.zeros(self.size)
        return self.load.at(self.parameters).toarray().ravel()

    @cached_property
    def displacements(self) -> Array:
        """The static displacements (n,)."""
        return self.statics.solve()

    @property
    def statics(self) -> Statics:
        """The static equations."""
        stiffness = self.structural_pencil.K.real.tocsc()
        return Statics(stiffness, self.load_vector, self.contacts, self.parameters)

    @property
    def contact_forces(self) -> list[ContactForces]:
        """Of each group of contacts, at the static displacements."""
        return [one.forces(self.displacements, self.parameters) for one in self.contacts]

    @property
    def static_stiffness(self) -> Matrix:
        """The real part of K + N (n, n) with what contacts add in steady sliding."""
        return self.statics.tangent(self.contact_forces).tocsc()

    @cached_property
    def law_states(self) -> tuple[tuple[str, ...], ...]:
        """Names of the states of each contact's friction law, as in motions; () of laws without states."""
        return names_of_law_states([one.friction for one in self.contacts for _ in range(one.count)])

    @staticmethod
    def steady_states(forces: list[ContactForces]) -> Array:
        """All states of friction laws at forces of steady sliding, those of one contact together."""
        return np.concatenate([np.zeros(0), *(each.states.T.ravel() for each in forces)])

    @property
    def order(self) -> int:
        """The number of eigenvalues: 2n, and one for each state of a friction law that lags."""
        return 2 * self.size + sum(one.count * len(one.lagging) for one in self.contacts)

    def pencil_derivative(self, parameter: str) -> QuadraticPencil:
        """The derivatives of M, C + G and K + N by a parameter, with those of the equilibrium."""
        check_parameter_name(self, parameter)
        given = self._pencil(lambda one: one.derivative(parameter, self.parameters))
        if not self.contacts:
            return given
        step = 1j * COMPLEX_STEP
        values = {**self.parameters, parameter: self.parameters[parameter] + step}
        pushed = sum(one.on_structure(one.forces(self.displacements, values)) for one in self.contacts)
        forces = given.K.real @ self.displacements - np.imag(pushed) / COMPLEX_STEP
        if self.load is not None:
            forces = forces - self.load.derivative(parameter, self.parameters).toarray().ravel()
        solve = factorised(self.static_stiffness)
        if solve is None:
            raise ValueError(
                f"the equilibrium must depend smoothly on {parameter} to have derivatives, got a singular "
                "stiffness: take another value"
            )
        moved = self.displacements - step * solve(forces)
        slopes = [
            ContactForces(*(np.imag(part) / COMPLEX_STEP for part in one.forces(moved, values)))
            for one in self.contacts
        ]
        return self.with_contacts(given, slopes)

    def replace(self, /, **changes: Any) -> Self:
        """The structure with other values of parameters, or other fields; no matrix is read again.

        Raises
        ------
        TypeError
            For an unknown name.
        ValueError
            As the constructor.
        """
        own = {each.name for each in fields(self)}
        for name in changes:
            if name not in own and name not in self.parameters:
                raise unknown_parameter(type(self).__name__, name, [*self.parameters, *sorted(own)])
        values = {name: value for name, value in changes.items() if name in self.parameters}
        others = {name: value for name, value in changes.items() if name not in values}
        own = _own_values(self.C, self.contacts)
        if values or not others.keys().isdisjoint(OWNERS):
            if isinstance(self.C, RayleighDamping) and "C" not in others:
                rates = asdict(self.C)  # they are its own, and go with it
                others["C"] = replace(self.C, **{name: values[name] for name in rates if name in values})
            if self.contacts and "contacts" not in others:
                others["contacts"] = tuple(one.with_values(values) for one in self.contacts)
            shared = {name: value for name, value in self.parameters.items() if name not in own}
            values = {name: value for name, value in values.items() if name not in own}
            others["parameters"] = {**shared, **(others.get("parameters") or {}), **values}
        copy = self._copied(**others)
        copy.__post_init__()
        return copy

    def automaton(self) -> HybridAutomaton:
        """The hybrid automaton of its motion; those that differ in values of parameters share its modes."""
        from frictionlab.structures.motion import automaton_of_structure

        return automaton_of_structure(self)

    def states_of_laws(self) -> StatesOfLaws:
        """What is known of states of friction laws where a run begins."""
        from frictionlab.structures.motion import states_of_laws

        return states_of_laws(self) if any(self.law_states) else StatesOfLaws()

    def undetermined_friction(self, mode: str) -> tuple[int, ...]:
        """Contacts whose friction forces in a mode of its motion are not unique, numbered from 1.

        More contacts stick than there are velocities, so that the equations give sums of these forces alone.
        The motion does not depend on how they are shared.  A run has one solution: that of contacts along one
        direction, by shares of their limits; else as many hold as needed, and others are at their limits.

        Parameters
        ----------
        mode : str
            As in ``run.mode``.

        Raises
        ------
        ValueError
            For no mode of the structure.

        Examples
        --------
        Two pads rub on one body, one of which travels twice as far:

        >>> import frictionlab as fl
        >>> pads = fl.SlidingContacts([[1.0], [2.0]], N=1.0, v=0.0)
        >>> fl.Structure([[1.0]], [[1.0]], contacts=pads).undetermined_friction("stick | stick")
        (1, 2)
        """
        from frictionlab.structures.motion import contacts_with_undetermined_friction

        return contacts_with_undetermined_friction(self, mode)

    def in_stick(self) -> ReducedStructure:
        """The structure whose contacts with counterparts at rest, v = 0, stick where they are closed.

        It has the freedoms that these contacts leave: each keeps its tangential displacement at zero, as
        without load.  Its eigenvalues are those of motions that are too small for the contacts to let go.
        Which contacts are closed, and that they hold, is found at the values at hand.

        Returns
        -------
        ReducedStructure
            ``basis @ q`` are the displacements of this structure.

        Raises
        ------
        ValueError
            Where there is no equilibrium, or a contact would have to hold by more than its static limit.

        Examples
        --------
        Of two masses between springs of 1 N/m, the second is pressed to a wall:

        >>> import frictionlab as fl
        >>> wall = fl.SlidingContacts([[0.0, 1.0]], N=1.0, v=0.0)
        >>> pair = fl.Structure([[1.0, 0.0], [0.0, 1.0]], [[2.0, -1.0], [-1.0, 2.0]], contacts=wall)
        >>> fl.eigenvalues(pair.in_stick()).values.imag.round(6).tolist()  # sqrt(2)
        [-1.414214, 1.414214]
        """
        from frictionlab.structures.stick import structure_in_stick

        return structure_in_stick(self)

    def eigenvalue_derivatives(self, value: complex) -> dict[str, complex]:
        """Derivatives of an eigenvalue, -y (dQ/dp) x / (y Q'(s) x), by the parameters on which M depends.

        They are NaN where its mode is not found, as that of a rigid motion.
        """
        mode = self.pencil.mode_at(value) if self.M.parameters else None
        if mode is None or not abs(mode.value - value) <= SAME_EIGENVALUE * abs(value):
            return dict.fromkeys(self.M.parameters, complex(np.nan, np.nan))
        return {name: self.pencil_derivative(name).slope_of(mode) for name in self.M.parameters}

    def energy_balance(self, automaton: HybridAutomaton, mode_names: Sequence[str]) -> StructureBalance:
        """Energies and powers along a run with these modes."""
        return StructureBalance(self, automaton, mode_names)

    def outputs_of_events(self, events: Any, states: Any) -> dict[str, Array]:
        """The impulses of `run.events` (E,), by their names; `states` (N, 2n) are those of the samples."""
        from frictionlab.structures.motion import impulses_by_name

        return impulses_by_name(self, events)

    def to_dict(self) -> dict[str, Any]:
        """Matrices, contacts and parameters as data that JSON can hold."""
        return {"system": "frictionlab:Structure", **structure_to_data(self)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Structure:
        """The structure that :meth:`to_dict` described.

        Raises
        ------
        ValueError
            If the data is malformed, or a law of your own is not defined in this session.
        """
        try:
            return Structure(**fields_from_data(data))
        except (AttributeError, KeyError, TypeError) as error:
            raise ValueError(f"a Structure cannot be made from {abbreviate(data)}: {error!r}") from error

    def find_equilibrium(self) -> Equilibrium:
        """The static displacements under load and contacts, which are zero without these."""
        return equilibrium_of(self)

    @cached_property
    def period(self) -> float:
        """Period (s) of the mode that grows fastest or decays most slowly; 0.1 s where none oscillates."""
        try:
            values = self.find_eigenvalues().values
        except ValueError:  # without an equilibrium
            return USUAL_PERIOD
        turning = values[values.imag > 0.0]
        return float(2 * np.pi / turning[turning.real.argmax()].imag) if len(turning) else USUAL_PERIOD

    def near_equilibrium(self) -> Array:
        """The equilibrium, displaced along the mode that grows fastest or decays most slowly.

        It is one percent of the displacement with which a contact would meet an event, or of one with that
        many times the static displacements.
        """
        modes = self.find_eigenvalues()
        first = int(np.argmax(modes.values.real))
        value, shape = modes.values[first], modes.vectors[: self.size, first]
        reach = [np.inf]
        for one, acting in zip(self.contacts, self.contact_forces, strict=True):
            reach += one.reach(acting, shape, value, self.parameters)
        size = min(reach)
        if not np.isfinite(size):
            size = np.abs(self.displacements).max() or 1.0
        way = NEAR * size * modes.vectors[:, first].real
        start = np.concatenate([self.displacements, np.zeros(self.size)]) + way[: 2 * self.size]
        states, lagging = [np.zeros(0)], way[2 * self.size :]
        for one in self.contacts:
            there = one.forces(start[: self.size] if not one.lagging else self.displacements, self.parameters)
            moved, lagging = np.split(lagging, [one.count * len(one.lagging)])
            states.append(there.states.T.ravel() + (moved if one.lagging else 0.0))
        return np.concatenate([start, *states])

    def find_eigenvalues(self) -> WindowEigenvalues:
        return window_eigenvalues(self, self.find_equilibrium())

    def find_root_locus(self, parameter: str, values: Any) -> RootLocus:
        from frictionlab.structures.mode_paths import locus_of_structure

        return locus_of_structure(self, parameter, values)

    def find_stability_changes(self, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
        from frictionlab.structures.changes_of_stability import find_stability_changes

        return find_stability_changes(self, parameter, bounds)

    def count_growing(self, parameter: str, value: float) -> int:
        return len(self.at_values({parameter: value}).find_eigenvalues().growing)

    def at_values(self, values: Mapping[str, float]) -> Self:
        """The structure with other values of some parameters.

        Unlike :meth:`replace` it does not ask for rules between parameters, as mu_s >= mu_k, on which no
        eigenvalue depends.
        """
        there = self._copied(parameters=MappingProxyType({**self.parameters, **values}))
        there._check_mass(False)
        return there

    def in_window(self, window: tuple[float, float]) -> Self:
        """The structure with another window, which is right."""
        return self._copied(window=window)

    def projected(self, basis: Any) -> ReducedStructure:
        """The projection on a real basis (n, r), full or sparse; on a full one of all freedoms the structure.

        Products with another such basis would leave rounding errors where a freedom has no mass.
        """
        if isinstance(basis, np.ndarray) and basis.shape[1] == self.size:
            basis = np.eye(self.size)
        small = object.__new__(ReducedStructure)  # what is right of this one is right of its projection
        for each in fields(Structure):
            part = getattr(self, each.name)
            if isinstance(part, ParametricMatrix):
                part = part.projected(basis)
            elif each.name == "contacts":
                part = tuple(one.projected(basis) for one in part)
            object.__setattr__(small, each.name, part)
        for name, value in (("full", self), ("basis", basis), ("error", np.nan)):
            object.__setattr__(small, name, value)
        return small

    def stacks(self, changes: Mapping[str, Any]) -> tuple[Array, Array, Array]:
        """M, C + G and K + N as full matrices (N, n, n) at arrays (N,) of parameters.

        They have a row for each freedom, then for each state of a friction law that lags.
        """
        count = max(np.size(values) for values in changes.values())
        values = {name: np.full(count, value) for name, value in self.parameters.items()}
        values |= {name: np.broadcast_to(np.ravel(column), (count,)) for name, column in changes.items()}
        size = self.order - self.size
        kinds = (np.result_type(float, *(m for one in terms for m in one.matrices)) for terms in self.terms)
        M, C, K = (np.zeros((count, size, size), kind) for kind in kinds)
        for matrix, terms in zip((M, C, K), self.terms, strict=True):
            for one in terms:
                matrix[:, : self.size, : self.size] += one.stack(values, count)
        if self.contacts:
            self._add_contacts(C, K, values)
        return M, C, K

    def spectra_over(self, box: Mapping[str, tuple[float, float]]) -> SpectraOf:
        from frictionlab.structures.mode_paths import spectra_over

        return spectra_over(self, box)

    def _add_contacts(self, C: Array, K: Array, values: Mapping[str, Array]) -> None:
        """Add what contacts add to stacked C and K; NaN where there is no equilibrium."""
        contacts = tuple(one.full() for one in self.contacts)
        forces = np.zeros((len(C), self.size))
        if self.load is not None:
            forces = self.load.stack(values, len(C))[..., 0]
        start, q, found = None, np.zeros_like(forces), np.zeros(len(C), dtype=bool)
        n = self.size
        held = K[:, :n, :n].real.copy()
        with suppress(ValueError):  # its own values may have no equilibrium where others have one
            start = self.displacements
        if start is not None:
            slides = np.ones(len(C), dtype=bool)
            for one in contacts:
                slides &= one.friction is None or values[one.parameter("v")] != 0.0
            columns = {name: column[slides] for name, column in values.items()}
            q[slides], found[slides] = newton_of_many(held[slides], forces[slides], contacts, columns, start)
        for i in np.flatnonzero(~found):
            point = {name: float(column[i]) for name, column in values.items()}
            try:
                q[i] = Statics(held[i], forces[i], contacts, point).solve(start)
            except ValueError:
                q[i] = np.nan
        known = np.isfinite(q).all(axis=1)
        C[~known], K[~known] = np.nan, np.nan
        columns = {name: column[known, None] for name, column in values.items()}
        first = n
        for one in contacts:
            acting = one.forces(q[known], columns)
            C[known, :n, :n] += one.damping(acting)
            K[known, :n, :n] += one.stiffness(acting)
            if one.lagging:
                rows, each = one.state_rows(acting), len(one.lagging)
                own = slice(first, first + one.count * each)
                K[known, :n, own], K[known, own, :n], C[known, own, :n] = rows[:3]
                for i in range(one.count):
                    block = slice(first + i * each, first + (i + 1) * each)
                    K[known, block, block] = rows.own_stiffness[:, i]
                diagonal = np.arange(own.start, own.stop)
                C[np.flatnonzero(known)[:, None], diagonal, diagonal] = rows.own_damping
                first = own.stop

    def _copied(self, **changes: Any) -> Self:
        """A copy with other values of fields, which are not checked."""
        copy = object.__new__(type(self))  # those made from dimensions have constructors of their own
        for each in fields(self):
            object.__setattr__(copy, each.name, changes.get(each.name, getattr(self, each.name)))
        return copy

    @property
    def terms(self) -> tuple[tuple[ParametricMatrix, ...], ...]:
        """What adds up to M, to C + G and to K + N."""
        damping = self.C
        if isinstance(damping, RayleighDamping):
            damping = self.M.scaled("alpha") + self.K.scaled("beta")
        sums = (self.M,), (damping, self.gyroscopic), (self.K, self.circulatory)
        return tuple(tuple(one for one in terms if one is not None) for terms in sums)

    def _pencil(self, value: Callable[[ParametricMatrix], Matrix]) -> QuadraticPencil:
        zero: Any = sparse.csc_array((self.size, self.size))
        return QuadraticPencil(*(sum(map(value, terms), zero) for terms in self.terms))

    def with_contacts(self, pencil: QuadraticPencil, forces: list[ContactForces]) -> QuadraticPencil:
        """The pencil with what forces of contacts add to C and K."""
        C, K = pencil.C, pencil.K
        rows: list[StateRows] = []
        for one, each in zip(self.contacts, forces, strict=True):
            C, K = C + one.damping(each), K + one.stiffness(each)
            rows += [one.state_rows(each)] if one.lagging else []
        if not rows:
            return QuadraticPencil(pencil.M, C.tocsc(), K.tocsc())
        of_states, stiffness, damping, blocks, diagonals = zip(*rows, strict=True)
        K_z = sparse.block_diag([block for some in blocks for block in some])
        C_z = sparse.diags_array(np.concatenate(diagonals))
        states = self.order - 2 * self.size
        none: Any = sparse.csc_array((states, states))
        M = sparse.block_diag([pencil.M, none], format="csc")
        C = sparse.block_array([[C, None], [sparse.vstack(damping), C_z]], format="csc")
        K = sparse.block_array([[K, sparse.hstack(of_states)], [sparse.vstack(stiffness), K_z]], format="csc")
        return QuadraticPencil(M, C, K, states)

    def _checked_contacts(self) -> tuple[SlidingContacts, ...]:
        given = self.contacts
        if given is None:
            return ()
        groups = (given,) if isinstance(given, SlidingContacts) else given
        cure = "give fl.SlidingContacts, or several in a list"
        for one in check_sequence("contacts", groups, cure):
            if not isinstance(one, SlidingContacts):
                raise TypeError(f"contacts must be SlidingContacts, got {abbreviate(one)}: {cure}")
        return tuple(groups)

    def _checked_parameters(self) -> Mapping[str, float]:
        given = {} if self.parameters is None else self.parameters
        check_mapping("parameters", given, 'give names and values, such as {"r": 5.0}')
        values = _own_values(self.C, self.contacts)
        for name, value in given.items():
            number = float(check_number(name, value))
            if values.setdefault(name, number) != number:
                owner = "RayleighDamping" if name in _own_values(self.C, ()) else "SlidingContacts"
                raise ValueError(
                    f"parameters must not contradict {owner}, got {name} = {number:.6g} beside its "
                    f"{values[name]:.6g}: give it once"
                )
        for name in values:
            if not name.isidentifier() or name in {each.name for each in fields(self)}:
                raise ValueError(
                    f"parameters must have names that can be keywords and are no field of Structure, got "
                    f"{name!r}: rename it"
                )
        return MappingProxyType(values)

    def _check_names_of_law_states(self) -> None:
        names = [name for some in self.law_states for name in some]
        taken = {*self.parameters, *self.coordinates} if names else set[str]()
        for name in names:
            if name in taken:
                raise ValueError(
                    f"the state {name!r} of a friction law must differ from freedoms, parameters and other "
                    "states: rename the parameter, or derive a class from the law with another name in its "
                    "states"
                )
            taken.add(name)

    def _check_units(self) -> None:
        cure = 'write those of length and force, units=("mm", "N")'
        given = check_sequence("units", self.units, cure)
        if len(given) != 2 or not all(isinstance(one, str) and one for one in given):
            raise ValueError(f"units must be two texts, got {abbreviate(self.units)}: {cure}")
        object.__setattr__(self, "units", given)

    def _check_sizes(self) -> None:
        for name in MATRICES:
            matrix = getattr(self, name)
            if isinstance(matrix, ParametricMatrix) and matrix.size != self.size:
                raise ValueError(
                    f"{name} must have the size of M, {self.size}, got {matrix.size}: give matrices of the "
                    "same freedoms"
                )
        for one in self.contacts:
            if one.size != self.size:
                raise ValueError(
                    f"contacts must have a column for each of {self.size} freedoms, got {one.size}: give "
                    "rows of the same freedoms"
                )

    def _check_use_of_parameters(self) -> None:
        own = asdict(self.C) if isinstance(self.C, RayleighDamping) else {}
        for name in MATRICES:
            matrix = getattr(self, name)
            for each in matrix.parameters if isinstance(matrix, ParametricMatrix) else ():
                if each in own:
                    raise ValueError(
                        f"a coefficient of {name} must not name {each!r}, which is RayleighDamping's own: "
                        "rename that parameter"
                    )
        used = {name for terms in self.terms for one in terms for name in one.parameters}
        used |= _own_values(self.C, self.contacts).keys()
        used |= set() if self.load is None else {*self.load.parameters}
        for name in self.parameters:
            if name not in used:
                raise ValueError(
                    f"parameters must be named by a coefficient, got {abbreviate(name)}, which none names: "
                    f"known are {shorten(sorted(used)) or 'none'}; leave it out or correct a coefficient"
                )

    def _check_symmetries(self, names: list[str]) -> None:
        cures = {
            "M": (1, "correct the export"),
            "K": (1, "give what friction adds, which is not symmetric, as circulatory"),
            "C": (1, "give its skew part (C - C.T)/2 as gyroscopic"),
            "gyroscopic": (-1, "give its symmetric part (G + G.T)/2 within C"),
        }
        for name, (sign, cure) in cures.items():
            if name in names:
                check_symmetry(name, getattr(self, name), sign, cure)
        for name in names:
            if name != "K" and any(matrix.dtype.kind == "c" for matrix in getattr(self, name).matrices):
                raise ValueError(
                    f"{name} must be real, got complex entries: only K may be complex, as K (1 + i eta) of "
                    "hysteretic damping; take the real part, or put the imaginary part into K"
                )

    def _check_mass(self, new: bool) -> None:
        if not new and not self.M.parameters:
            return
        mass = self.M.at(self.parameters)
        held = _largest_in_rows(mass) > 0.0
        diagonal = mass.diagonal()
        wrong = np.flatnonzero(held & ~(diagonal > 0.0))
        cure = "correct the export, or the values of parameters"
        if wrong.size:
            listed = shorten(map(str, wrong), SHOWN)
            raise ValueError(
                f"M must be positive, got {diagonal[wrong[0]]:.6g} on the diagonal at {listed}: {cure}"
            )
        if not held.any():
            raise ValueError(f"M must give a freedom a mass, got zeros only: {cure}")
        least, freedom = _least_eigenvalue(mass[held][:, held], 1.0 / np.sqrt(diagonal[held]))
        if least < -INDEFINITE_SHARE:
            raise ValueError(
                f"M must be positive, got a motion with negative kinetic energy, most of it at the freedom "
                f"{np.flatnonzero(held)[freedom]}: {cure}"
            )

    def __getstate__(self) -> dict[str, Any]:  # what is computed from the fields is computed again
        state = {each.name: getattr(self, each.name) for each in fields(self)}
        return state | {"parameters": dict(self.parameters)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, MappingProxyType(value) if name == "parameters" else value)

    def __repr__(self) -> str:
        parts = [count(self.size, "freedom")]
        parts += [count(sum(one.count for one in self.contacts), "contact")] if self.contacts else []
        parts += [f"{name}={value:.6g}" for name, value in self.parameters.items()]
        parts += ["{:g} to {:g} Hz".format(*self.window)] if self.window else []
        return f"{type(self).__name__}({', '.join(parts)})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{escape(_described(getattr(self, name)))}</td></tr>"
            for name in MATRICES
            if getattr(self, name) is not None
        )
        return f"<p>{escape(repr(self))}</p><table>{rows}</table>"


def _own_values(damping: Any, contacts: tuple[SlidingContacts, ...]) -> dict[str, float]:
    """Values of the parameters that Rayleigh damping and contacts have of their own."""
    values = asdict(damping) if isinstance(damping, RayleighDamping) else {}
    for one in contacts:
        for name, value in one.parameters.items():
            if values.setdefault(name, value) != value:
                raise ValueError(
                    f"parameters of the same name must have one value, got {name} = {values[name]:.6g} and "
                    f'{value:.6g}: name the contacts, as SlidingContacts(..., name="inner") has {name}_inner'
                )
    return values


def _described(matrix: Any) -> str:
    """A matrix in a notebook: its terms, and how many entries each has."""
    if not isinstance(matrix, ParametricMatrix):
        return repr(matrix)
    terms = zip(matrix.coefficients, matrix.matrices, strict=True)
    return " + ".join(("" if text == "1" else f"({text}) × ") + f"{one.nnz:,} entries" for text, one in terms)


def _largest_in_rows(matrix: Matrix) -> Array:
    return abs(matrix).max(axis=1).toarray().ravel()


def _least_eigenvalue(mass: Matrix, scales: Array) -> tuple[float, int]:
    """The least eigenvalue of a mass matrix scaled to a diagonal of ones, and the freedom with most of it."""
    scaled = sparse.diags_array(scales) @ mass @ sparse.diags_array(scales)
    if scaled.shape[0] <= MOST_DENSE:
        values, vectors = np.linalg.eigh(scaled.toarray())
    else:
        start = np.random.default_rng(0).standard_normal(scaled.shape[0])
        lanczos: Any = sparse_linalg.eigsh  # its stub takes an integer for the tolerance
        values, vectors = lanczos(scaled, k=1, which="SA", tol=LANCZOS_TOL, v0=start)
    return float(values[0]), int(np.abs(vectors[:, 0]).argmax())


@dataclass(frozen=True, eq=False, repr=False)
class ReducedStructure(Structure):
    """A structure of r freedoms, whose displacements are those of a large one in the span of a basis.

    It is made by :func:`reduce`, or by :meth:`Structure.in_stick`.  Parameters, contacts and load are those
    of the large structure.

    Parameters
    ----------
    full : Structure
        The large one, with n freedoms.
    basis : array (n, r)
        Orthonormal, or sparse in stick: ``basis @ q`` are the displacements of the large structure.
    error : float
        Largest error of its eigenvalues, as a share, at and between samples of the large structure's; NaN
        where it was not measured.
    """

    full: Structure = field(kw_only=True)
    basis: Array = field(kw_only=True)
    error: float = field(kw_only=True, default=np.nan)

    def expanded(self, vectors: Any) -> Any:
        """Vectors of the large structure's pencil by those of this one's: states of laws are the same."""
        return np.vstack([self.basis @ vectors[: self.size], vectors[self.size :]])

    def restricted(self, vectors: Any) -> Any:
        """Vectors of this structure's pencil by those of the large one's in the span of the basis."""
        return np.vstack([self.basis.T @ vectors[: self.full.size], vectors[self.full.size :]])

    def replace(self, /, **changes: Any) -> Self:
        """The structure with other values of parameters, or another window."""
        for name in changes:
            if name not in self.parameters and name not in ("parameters", "window"):
                raise ValueError(
                    f"only parameters and window of a reduced structure can be replaced, got {name!r}: "
                    "change the large structure, and reduce it again"
                )
        return super().replace(**changes)

    def error_estimates(self) -> Array:
        """Estimated distances (m,) of ``eigenvalues(self).values`` from those of the large structure, 1/s.

        By so much they move where responses of the large structure to what the modes leave in its equations
        join the basis.  :meth:`error_bounds` takes longer, and gives bounds.
        """
        from frictionlab.structures.reduction import estimated_errors

        return estimated_errors(self)

    def error_bounds(self, modes: Any = None) -> Array:
        """Bounds (m,) of the distances of ``eigenvalues(self).values`` from the large structure's, 1/s.

        Within each distance there is an eigenvalue of the large structure, and of close ones as many as there
        are here.  A distance is infinite where the modes here are too rough to tell, or nearly rigid.  A
        rigid motion, whose elastic energy in the large structure is rounding, has the eigenvalue 0 there, so
        that its distance is the size of the eigenvalue here.

        Each group of close eigenvalues takes a factorisation of the large matrices.  The bounds rest on
        Rouche's theorem.  Rounding is estimated in them, and so are two norms of inverses for each group: one
        of these is too small with a probability of at most 2e-10.

        Parameters
        ----------
        modes : array of int, optional
            Places of eigenvalues, such as ``eigenvalues(self).growing``.  Without them all.

        Raises
        ------
        IndexError
            For a place that no eigenvalue has.
        """
        from frictionlab.structures.reduction import bounded_errors

        return bounded_errors(self, modes)

    def __repr__(self) -> str:
        return super().__repr__().replace("(", f"({self.full.size} freedoms to ", 1)
