"""`fl.DiscBrake`: an annular plate between two pads, from its dimensions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag

from frictionlab.components.contact import ContactLaw, LinearContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.structures.beam_on_belt import hermite_functions
from frictionlab.structures.sliding_contacts import SlidingContacts
from frictionlab.structures.structure import Structure
from frictionlab.validation import abbreviate, check_field, check_number, explains_fields

Array = NDArray[np.float64]
MOST_POINTS = 50
GAUSS_POINTS = 6  # of an element: what they leave is far below the element's own error
CONTACT, FRICTION = LinearContact(k2=1e7), Coulomb(mu_k=0.4, mu_s=0.6)
PRELOAD, SPEED = 2000.0, 1.0  # N, m/s
ALPHA, BETA = 20.0, 1e-7  # shares of M (1/s) and K (s) in the damping
WINDOW = (0.0, 5000.0)  # Hz


@explains_fields
@dataclass(frozen=True)
class AnnularPlate:
    """A thin annular plate, clamped at its inner edge and free at its outer one.

    Kirchhoff's theory.  The deflection is a sum of W_n(r) cos(n theta) and W_n(r) sin(n theta) over the nodal
    diameters n, which is exact in theta; W_n is cubic in each element along r.  Frequencies converge with the
    fourth power of an element's length.

    Parameters
    ----------
    inner, outer : float
        Radii, m.
    thickness : float
        m.
    young : float
        Young's modulus, N/m^2.
    poisson : float
        Poisson's ratio.
    density : float
        kg/m^3.
    elements : int
        Along the radius.
    diameters : int
        The largest number of nodal diameters.

    Raises
    ------
    ValueError
        For radii that do not ascend, or other values that are impossible.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.AnnularPlate().size
    104
    """

    inner: float = 0.05
    outer: float = 0.14
    thickness: float = 0.012
    young: float = 1.1e11
    poisson: float = 0.28
    density: float = 7100.0
    elements: int = 4
    diameters: int = 6

    def __post_init__(self) -> None:
        for name in ("inner", "outer", "thickness", "young", "density"):
            check_field(self, name, above=0.0, cure="give it in SI units")
        check_field(self, "outer", above=self.inner, cure="give the radius of the free edge")
        check_field(self, "poisson", least=0.0, below=0.5, cure="that of steel is 0.3")
        check_field(self, "elements", integer=True, least=1, most=1000, cure="4 suit a few kHz")
        check_field(self, "diameters", integer=True, least=0, most=1000, cure="8 suit a few kHz")

    @property
    def size(self) -> int:
        """The number of freedoms: two of each free node, for each of the functions of theta."""
        return 2 * self.elements * (2 * self.diameters + 1)

    def matrices(self) -> tuple[Any, Any]:
        """M and K (n, n), sparse; functions of theta follow each other as 1, cos, sin, cos 2, ..."""
        masses, stiffnesses = [], []
        for n in range(self.diameters + 1):
            mass, stiffness = self._radial_matrices(n)
            masses += [mass] * min(n + 1, 2)
            stiffnesses += [stiffness] * min(n + 1, 2)
        return sparse.csc_array(block_diag(*masses)), sparse.csc_array(block_diag(*stiffnesses))

    def _radial_matrices(self, n: int) -> tuple[Array, Array]:
        """Those of W_n.  The curvatures are W'', W'/r - n^2 W/r^2, and the twist n (W/r)'."""
        bending = self.young * self.thickness**3 / (12.0 * (1.0 - self.poisson**2))
        size, h = 2 * (self.elements + 1), (self.outer - self.inner) / self.elements
        mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
        circle = np.pi if n else 2.0 * np.pi  # the integral of cos^2 over the circumference
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        for i in range(self.elements):
            place = slice(2 * i, 2 * i + 4)
            for share, weight in zip(0.5 * (1.0 + nodes), 0.5 * weights * h * circle, strict=True):
                r = self.inner + h * (i + share)
                W, slope, radial = hermite_functions(share, h)
                hoop, twist = slope / r - n**2 * W / r**2, n * (slope / r - W / r**2)
                product = np.outer(radial, hoop)
                curved = np.outer(radial, radial) + np.outer(hoop, hoop)
                curved += self.poisson * (product + product.T)
                curved += 2.0 * (1.0 - self.poisson) * np.outer(twist, twist)
                stiffness[place, place] += weight * r * bending * curved
                mass[place, place] += weight * r * self.density * self.thickness * np.outer(W, W)
        return mass[2:, 2:], stiffness[2:, 2:]  # the inner edge is clamped

    def rows(self, r: Any, theta: Any) -> tuple[Array, Array]:
        """Rows (k, n) of the deflection at points (k,), and of its slope along the circumference."""
        r, theta = (np.atleast_1d(np.asarray(each, dtype=float)) for each in np.broadcast_arrays(r, theta))
        h, nodes = (self.outer - self.inner) / self.elements, 2 * (self.elements + 1)
        at = np.clip(((r - self.inner) / h).astype(int), 0, self.elements - 1)
        W = np.zeros((len(r), nodes))
        values = hermite_functions((r - self.inner) / h - at, h)[0]
        W[np.arange(len(r))[:, None], 2 * at[:, None] + np.arange(4)] = values.T
        n = np.arange(1, self.diameters + 1)
        angles = theta[:, None] * n
        waves, slopes = np.ones((len(r), 2 * len(n) + 1)), np.zeros((len(r), 2 * len(n) + 1))
        waves[:, 1::2], waves[:, 2::2] = np.cos(angles), np.sin(angles)
        slopes[:, 1::2], slopes[:, 2::2] = -n * np.sin(angles), n * np.cos(angles)
        slopes /= r[:, None]
        parts = (each[:, :, None] * W[:, None, 2:] for each in (waves, slopes))
        deflections, along = (part.reshape(len(r), self.size) for part in parts)
        return deflections, along


@explains_fields
@dataclass(frozen=True, eq=False, repr=False, init=False)
class DiscBrake(Structure):
    """A disc between two pads, which press on both its faces at some points and rub.

    The disc is an :class:`AnnularPlate`.  Each pad is a rigid body that moves along the disc's normal, where
    the preload F pushes it, and along the circumference, where a spring holds it.  Friction acts at the faces
    of the disc, half a thickness off its middle, and bends it, by moments that grow with the deflection.  So
    the stiffness is not symmetric, and doublets of modes flutter.  The disc turns so slowly that its rotation
    adds no forces.

    Freedoms are the pads' displacements along normal and circumference, of the first and of the second pad,
    then those of the plate.  Parameters are those of the laws, v, F, alpha and beta.

    Parameters
    ----------
    plate : AnnularPlate
    contact : ContactLaw
        Of each point of a pad.
    friction : FrictionLaw
    pad_angle : float
        Angle (rad) from the first to the last point of a pad.
    pad_radius : float
        At which radius the pads press, m.
    pad_mass : float
        Of each pad, kg.
    pad_stiffness : float
        That holds a pad along the circumference, N/m.
    pad_damping : float
        Of both motions of a pad, N s/m.
    points : int
        Of each pad.

    Raises
    ------
    ValueError
        For values that are impossible, or pads beside the plate.

    Examples
    --------
    >>> import frictionlab as fl
    >>> brake = fl.DiscBrake()
    >>> round(fl.critical_value(brake, "mu_k", (0.1, 0.6)), 4)
    0.304
    >>> fl.eigenvalues(brake)
    WindowEigenvalues(15 modes, 630.1 to 3984 Hz, 1 growing: +11.65/s at 2709.4 Hz)
    """

    plate: AnnularPlate = field(kw_only=True)

    def __init__(
        self,
        plate: AnnularPlate | None = None,
        *,
        contact: ContactLaw = CONTACT,
        friction: FrictionLaw = FRICTION,
        pad_angle: float = 0.7,
        pad_radius: float = 0.115,
        pad_mass: float = 0.4,
        pad_stiffness: float = 5e7,
        pad_damping: float = 800.0,
        points: int = 3,
    ) -> None:
        plate = AnnularPlate() if plate is None else plate
        if not isinstance(plate, AnnularPlate):
            raise TypeError(f"plate must be a fl.AnnularPlate, got {abbreviate(plate)}: give one")
        points = check_number("points", points, integer=True, least=1, most=MOST_POINTS, cure="3 suit a pad")
        check_number("pad_angle", pad_angle, least=0.0, below=2 * np.pi, cure="give it in rad")
        cure = f"give one on the plate, {plate.inner} to {plate.outer} m"
        check_number("pad_radius", pad_radius, above=plate.inner, most=plate.outer, cure=cure)
        check_number("pad_mass", pad_mass, above=0.0, cure="give it in kg")
        check_number("pad_stiffness", pad_stiffness, above=0.0, cure="give it in N/m")
        check_number("pad_damping", pad_damping, least=0.0, cure="give it in N s/m")
        theta = np.linspace(-0.5, 0.5, points) * pad_angle if points > 1 else np.zeros(1)
        deflection, slope = plate.rows(np.full(points, pad_radius), theta)
        turned = 0.5 * plate.thickness * slope
        one, zero = np.ones((points, 1)), np.zeros((points, 1))
        # Towards the disc both pads penetrate; a face moves along the circumference as the plate turns.
        normal = np.block([[one, zero, zero, zero, deflection], [zero, zero, one, zero, -deflection]])
        tangential = np.block([[zero, one, zero, zero, turned], [zero, zero, zero, one, -turned]])
        mass, stiffness = plate.matrices()
        pads = np.array([0.0, pad_stiffness, 0.0, pad_stiffness])
        pushed = np.zeros(4 + plate.size)
        pushed[[0, 2]] = 1.0
        M = sparse.block_diag([pad_mass * np.eye(4), mass], format="csc")
        K = sparse.block_diag([np.diag(pads), stiffness], format="csc")
        dampers = sparse.diags_array(np.where(np.arange(4 + plate.size) < 4, pad_damping, 0.0))
        object.__setattr__(self, "plate", plate)
        super().__init__(
            M,
            K,
            C=[("alpha", M), ("beta", K), (1.0, dampers)],
            load=[("F", pushed)],
            contacts=SlidingContacts(tangential, normal, contact, friction, v=SPEED),
            parameters={"F": PRELOAD, "alpha": ALPHA, "beta": BETA},
            window=WINDOW,
        )

    def replace(self, /, **changes: Any) -> Self:
        """The brake with other values of parameters, or other fields but the plate."""
        if "plate" in changes:
            raise ValueError(
                f"plate must stay, as matrices are made from it, got {abbreviate(changes['plate'])}: make "
                "another DiscBrake"
            )
        return super().replace(**changes)
