"""`fl.BeamOnBelt`: an elastic beam that is pressed against a moving belt, from its dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.contact import ContactLaw, LinearContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.structures.damping import RayleighDamping
from frictionlab.structures.sliding_contacts import SlidingContacts
from frictionlab.structures.structure import Structure
from frictionlab.validation import check_number, check_sequence, explains_fields

Array = NDArray[np.float64]
PRELOAD, SPEED = 10.0, 1.0  # N at each contact, m/s
CONTACT, FRICTION = LinearContact(k2=1e8), Coulomb(mu_k=0.4, mu_s=0.6)
DAMPING = RayleighDamping(alpha=1.0, beta=1e-7)
MOST_ELEMENTS = 1000
GAUSS_POINTS = 4  # exact for products of cubics


def hermite_functions(share: Any, h: float) -> tuple[Array, Array, Array]:
    """The four cubic functions of an element of length h at a share of it, their slopes and curvatures.

    They have the deflection 1, the slope 1 at the first and at the second node.
    """
    s = np.asarray(share, dtype=float)
    values = np.array([1 - 3 * s**2 + 2 * s**3, h * s * (1 - s) ** 2, s**2 * (3 - 2 * s), h * s**2 * (s - 1)])
    slopes = np.array([6 * s * (s - 1) / h, (1 - s) * (1 - 3 * s), 6 * s * (1 - s) / h, s * (3 * s - 2)])
    curvatures = np.array([(12 * s - 6) / h**2, (6 * s - 4) / h, (6 - 12 * s) / h**2, (6 * s - 2) / h])
    return values, slopes, curvatures


@explains_fields
class BeamOnBelt(Structure):
    """A beam, clamped at one end, that is pressed against a moving belt at some of its nodes and rubs.

    Euler's and Bernoulli's beam in bending, with cubic functions of each element, and a bar along its axis,
    with linear ones: frequencies of bending converge with the fourth power of an element's length, those of
    the axis with the second.  Its axis dips towards the belt by an angle.  Friction acts at the beam's
    surface, half its height off the axis, and couples bending and axis: modes flutter.

    Freedoms of each node but the clamped one are the displacements along the axis and towards the belt, and
    the slope.  Parameters are those of the laws, v, F, alpha and beta.

    Parameters
    ----------
    elements : int
    length : float
        m.
    bending : float
        Bending stiffness, N m^2.
    axial : float
        Axial stiffness, N.  The height is that of a rectangle, sqrt(12 bending/axial).
    mass : float
        kg/m.
    angle : float
        Between axis and belt, rad.
    nodes : sequence of int
        Which touch the belt, counted from the clamped one, 0; negative ones from the free end, -1.
    contact : ContactLaw
    friction : FrictionLaw

    Raises
    ------
    ValueError
        For values that are impossible, or nodes that there are not.

    Examples
    --------
    >>> import frictionlab as fl
    >>> beam = fl.BeamOnBelt(elements=12)
    >>> round(fl.critical_value(beam, "mu_k", (0.02, 0.8)), 4)
    0.0615
    """

    def __init__(
        self,
        elements: int = 20,
        *,
        length: float = 0.3,
        bending: float = 333.0,
        axial: float = 4e7,
        mass: float = 1.56,
        angle: float = 1.4,
        nodes: Sequence[int] = (-1,),
        contact: ContactLaw = CONTACT,
        friction: FrictionLaw = FRICTION,
    ) -> None:
        elements = check_number(
            "elements", elements, integer=True, least=1, most=MOST_ELEMENTS, cure="take 20"
        )
        sizes = {"length": length, "bending": bending, "axial": axial, "mass": mass}
        for name, value in sizes.items():
            check_number(name, value, above=0.0, cure="give it in SI units")
        check_number("angle", angle, least=0.0, most=np.pi / 2, cure="give it in rad, from 0 to pi/2")
        at = np.array([_node(each, elements) for each in check_sequence("nodes", nodes, "write (-1,)")], int)
        if not len(at):
            raise ValueError("nodes must name one that touches the belt, got none: write (-1,)")
        h = length / elements
        M, K = _matrices(elements, h, bending, axial, mass)
        size = len(M)
        across, along, slope = 3 * at + 1, 3 * at, 3 * at + 2
        half = np.sqrt(3.0 * bending / axial)  # of the height
        axis, towards = np.zeros((2, len(at), size))
        each = np.arange(len(at))
        axis[each, along], axis[each, slope], towards[each, across] = 1.0, -half, 1.0
        normal = np.sin(angle) * axis + np.cos(angle) * towards
        tangential = np.cos(angle) * axis - np.sin(angle) * towards
        gaps = np.sin(angle) * (elements - at) * h
        free = slice(3, None)  # the first node is clamped
        rows = tangential[:, free], normal[:, free]
        super().__init__(
            M[free, free],
            K[free, free],
            DAMPING,
            load=[("F", rows[1].sum(axis=0))],
            contacts=SlidingContacts(*rows, contact, friction, v=SPEED, penetration=-gaps),
            parameters={"F": PRELOAD},
        )


def _node(given: Any, elements: int) -> int:
    cure = f"count nodes from 1 to {elements}, or from the free end, -1"
    node = check_number("nodes", given, integer=True, least=-elements, most=elements, cure=cure)
    if node == 0:
        raise ValueError(f"nodes must not be clamped, got 0: {cure}")
    return node % (elements + 1)


def _matrices(elements: int, h: float, bending: float, axial: float, mass: float) -> tuple[Array, Array]:
    """M and K of all nodes, also the clamped one."""
    size = 3 * (elements + 1)
    M, K = np.zeros((size, size)), np.zeros((size, size))
    parts = _element_matrices(h, bending, axial, mass)
    for i in range(elements):
        place = slice(3 * i, 3 * i + 6)
        M[place, place] += parts[0]
        K[place, place] += parts[1]
    return M, K


def _element_matrices(h: float, bending: float, axial: float, mass: float) -> tuple[Array, Array]:
    """M and K (6, 6) of axial displacement, deflection and slope at both nodes."""
    M, K = np.zeros((6, 6)), np.zeros((6, 6))
    bar, beam = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    K[bar] = axial / h * np.array([[1, -1], [-1, 1]])
    M[bar] = mass * h / 6 * np.array([[2, 1], [1, 2]])
    shares, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    values, _, curvatures = hermite_functions(0.5 * (1.0 + shares), h)
    K[beam] = bending * (curvatures * (0.5 * h * weights)) @ curvatures.T
    M[beam] = mass * (values * (0.5 * h * weights)) @ values.T
    return M, K
