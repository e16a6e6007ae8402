"""Dynamic friction laws, which have states of their own: LuGre, Dahl, Jenkins, Iwan, rate and state.

A state is the deflection of bristles, or how long a contact has rested.  v_r has either sign in force and
rates, which are written with ``abs(relative_velocity)`` where they depend on the speed alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import isclose
from typing import Any, ClassVar

from frictionlab.validation import check_number, check_sequence

from .component import parameter
from .friction import FrictionLaw, check_coefficients
from .functions import arcsinh, exp, log

MOST_ELEMENTS = 30  # of Iwan's


def _bristle_stiffness() -> Any:
    return parameter(
        1e4,
        unit="1/m",
        symbol=r"\sigma_0",
        meaning="stiffness of the bristles per normal force",
        exclusive_minimum=0.0,
        range=(1e2, 1e6),
        log=True,
    )


def _coefficient(default: float, symbol: str, meaning: str) -> Any:
    return parameter(
        default,
        symbol=rf"\mu_{{\mathrm{{{symbol}}}}}",
        meaning=meaning,
        exclusive_minimum=0.0,
        range=(0.01, 3.0),
    )


def _tangential_stiffness() -> Any:
    return parameter(
        100.0,
        unit="N/m",
        symbol=r"k_{\mathrm{t}}",
        meaning="tangential stiffness of the contact",
        exclusive_minimum=0.0,
        range=(1.0, 1e7),
        log=True,
    )


@dataclass(frozen=True, repr=False)
class Dahl(FrictionLaw):
    """Dahl's law: F_T = sigma_0 z F_N, z' = v_r - sigma_0 |v_r| z / mu_k.

    Friction rises with the displacement as of a spring, and tends to mu_k F_N; it does not depend on speed.

    Parameters
    ----------
    mu_k : float
        Coefficient of friction in steady sliding, above 0.
    sigma_0 : float
        Stiffness of the bristles per normal force, 1/m, above 0.

    References
    ----------
    P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1 (1968).
    """

    states: ClassVar[tuple[str, ...]] = ("z",)
    mu_k: float = _coefficient(0.3, "k", "coefficient of friction in steady sliding")
    sigma_0: float = _bristle_stiffness()

    def force(self, normal_force: Any, relative_velocity: Any, z: Any) -> Any:
        """sigma_0 z F_N (N), at a deflection z (m)."""
        return self.sigma_0 * z * normal_force

    def rates(self, normal_force: Any, relative_velocity: Any, z: Any) -> dict[str, Any]:
        """The rate of the deflection, m/s."""
        rate = relative_velocity - self.sigma_0 * abs(relative_velocity) / self.mu_k * z
        return {self.states[0]: rate}

    def stored_energy(self, normal_force: Any, z: Any) -> Any:
        """Energy (J) of the bristles as springs, sigma_0 z^2 F_N/2."""
        return self.sigma_0 * z**2 / 2 * normal_force


@dataclass(frozen=True, repr=False)
class LuGre(FrictionLaw):
    """The LuGre law: F_T = (sigma_0 z + sigma_1 z' + sigma_2 v_r) F_N, z' = v_r - sigma_0 |v_r| z / mu(v_r).

    Here mu = mu_k + (mu_s - mu_k) exp(-(v_r/v_s)^2).  In steady sliding z = mu/sigma_0 along v_r.

    Parameters
    ----------
    mu_k, mu_s : float
        Coefficients of kinetic and static friction, 0 < mu_k <= mu_s.
    v_s : float
        Stribeck speed, m/s, above 0.
    sigma_0 : float
        Stiffness of the bristles per normal force, 1/m, above 0.
    sigma_1 : float
        Damping of the bristles per normal force, s/m, at least 0.
    sigma_2 : float
        Viscous coefficient, s/m, at least 0.

    References
    ----------
    C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, IEEE Transactions on Automatic Control 40
    (1995) 419-425; in proportion to F_N: C. Canudas de Wit, P. Tsiotras, Proceedings of the 38th IEEE
    Conference on Decision and Control (1999) 3746-3751.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.MassOnBelt(friction=fl.LuGre())
    >>> float(fl.simulate(model, 0.1, x0={"z": 1e-5})["z"][0])
    1e-05
    """

    states: ClassVar[tuple[str, ...]] = ("z",)
    mu_k: float = _coefficient(0.3, "k", "coefficient of kinetic friction")
    mu_s: float = _coefficient(0.5, "s", "coefficient of static friction")
    v_s: float = parameter(
        0.1,
        unit="m/s",
        symbol=r"v_{\mathrm{s}}",
        meaning="speed over which friction decays",
        exclusive_minimum=0.0,
        range=(0.001, 10.0),
        log=True,
    )
    sigma_0: float = _bristle_stiffness()
    sigma_1: float = parameter(
        10.0,
        unit="s/m",
        symbol=r"\sigma_1",
        meaning="damping of the bristles per normal force",
        minimum=0.0,
        range=(0.0, 100.0),
    )
    sigma_2: float = parameter(
        0.0, unit="s/m", symbol=r"\sigma_2", meaning="viscous coefficient", minimum=0.0, range=(0.0, 1.0)
    )

    def check(self) -> None:
        """Refuse static friction below kinetic friction."""
        check_coefficients(self.mu_k, self.mu_s)

    def force(self, normal_force: Any, relative_velocity: Any, z: Any) -> Any:
        """Friction force (N) at a deflection z (m)."""
        bristles = self.sigma_0 * z + self.sigma_1 * self._deflection_rate(relative_velocity, z)
        return (bristles + self.sigma_2 * relative_velocity) * normal_force

    def rates(self, normal_force: Any, relative_velocity: Any, z: Any) -> dict[str, Any]:
        """The rate of the deflection, m/s."""
        return {self.states[0]: self._deflection_rate(relative_velocity, z)}

    def stored_energy(self, normal_force: Any, z: Any) -> Any:
        """Energy (J) of the bristles as springs, sigma_0 z^2 F_N/2."""
        return self.sigma_0 * z**2 / 2 * normal_force

    def _deflection_rate(self, relative_velocity: Any, z: Any) -> Any:
        decay = (self.mu_s - self.mu_k) * exp(-((relative_velocity / self.v_s) ** 2))
        return relative_velocity - self.sigma_0 * abs(relative_velocity) / (self.mu_k + decay) * z


@dataclass(frozen=True, repr=False)
class Jenkins(FrictionLaw):
    """Jenkins' element, a spring in series with a slider: F_T = k_t z, z' = v_r while |z| < mu_k F_N/k_t.

    At its limit the slider slips and F_T = mu_k F_N along v_r.  The mode "stick" is that of the spring alone.
    Several of them side by side are :class:`Iwan`'s.

    Parameters
    ----------
    mu_k : float
        Coefficient of friction of the slider, above 0.
    k_t : float
        Tangential stiffness, N/m, above 0.

    References
    ----------
    G. M. Jenkins, British Journal of Applied Physics 13 (1962) 30-32; W. D. Iwan, Journal of Applied
    Mechanics 33 (1966) 893-900.
    """

    states: ClassVar[tuple[str, ...]] = ("z",)
    mu_k: float = _coefficient(0.3, "k", "coefficient of friction of the slider")
    k_t: float = _tangential_stiffness()

    def force(self, normal_force: Any, relative_velocity: Any, z: Any) -> Any:
        """Friction force (N) at a deflection z (m)."""
        return self.k_t * z

    def rates(self, normal_force: Any, relative_velocity: Any, z: Any) -> dict[str, Any]:
        """The rate of the deflection while the slider sticks, m/s."""
        return {self.states[0]: relative_velocity}

    def stored_energy(self, normal_force: Any, z: Any) -> Any:
        """Energy (J) of the spring, k_t z^2/2."""
        return self.k_t * z**2 / 2

    def state_limit(self, normal_force: Any) -> Any:
        """The deflection (m) at which the slider slips."""
        return self.mu_k * normal_force / self.k_t


@dataclass(frozen=True, repr=False)
class Iwan(FrictionLaw):
    """Iwan's element, n of Jenkins' side by side: F_T = sum of k_i z_i, z_i' = v_r while |z_i| < F_i/k_i.

    They slip one after the other, and the contact passes from stick through partial slip to slip, where
    F_T = mu_k F_N along v_r.  By default all have the stiffness k_i = k_t/n, and the forces at which they
    slip are evenly spread, F_i = (2 i - 1)/n^2 mu_k F_N.  The first loading then follows Iwan's
    uniform distribution, F_T = k_t x - (k_t x)^2/(4 mu_k F_N) up to x = 2 mu_k F_N/k_t, in straight lines.
    They bend where an element slips, and touch this parabola halfway between.

    A mode's name has the regime of each element, as in "contact | slip+ | stick | stick".  There is no limit
    mode of chatter: of impacts that accumulate, as those of `SliderOnBelt`, each flight is computed, which
    takes some eight times the events that :class:`Jenkins` takes.

    Parameters
    ----------
    mu_k : float
        Coefficient of friction where all elements slip, above 0.
    k_t : float
        Tangential stiffness where all stick, N/m, above 0.
    elements : int
        n, from 1 to 30.
    strengths, stiffnesses : sequence of float or None
        For each element in proportion to what F_i and k_i are; None for those above.

    References
    ----------
    W. D. Iwan, Journal of Applied Mechanics 33 (1966) 893-900.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.MassOnBelt(friction=fl.Iwan())
    >>> fl.simulate(model, 1.0).names
    ('x', "x'", 'z1', 'z2', 'z3')
    """

    mu_k: float = _coefficient(0.3, "k", "coefficient of friction of all sliders")
    k_t: float = _tangential_stiffness()
    elements: int = 3
    strengths: tuple[float, ...] | None = None
    stiffnesses: tuple[float, ...] | None = None

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the deflections: z1, z2, ..."""
        return tuple(f"z{i + 1}" for i in range(self.elements))

    def __post_init__(self) -> None:
        n = check_number("elements", self.elements, integer=True, least=1, most=MOST_ELEMENTS)
        object.__setattr__(self, "elements", n)
        for name in ("strengths", "stiffnesses"):
            given, cure = getattr(self, name), f"write {name}=(1.0, 2.0), with elements=2, or leave it out"
            if given is None:
                continue
            each = check_sequence(name, given, cure)
            numbers = tuple(check_number(f"each of {name}", one, above=0, cure=cure) for one in each)
            if len(numbers) != n:
                raise ValueError(
                    f"{name} must have one number for each of {n} elements, got {len(numbers)}: {cure}"
                )
            object.__setattr__(self, name, numbers)
        super().__post_init__()

    def check(self) -> None:
        """Refuse elements that slip together."""
        ratios = sorted(f / k for f, k in zip(self._f, self._k))
        if any(isclose(one, following) for one, following in pairwise(ratios)):
            raise ValueError(
                "strengths must be in different ratios to stiffnesses, as elements that slip together are "
                f"one, got {self._f} and {self._k}: add up those of such elements"
            )

    def force(self, normal_force: Any, relative_velocity: Any, *z: Any) -> Any:
        """Friction force (N) at the deflections z_i (m)."""
        return self.k_t * sum(k * one for k, one in zip(self._k, z)) / sum(self._k)

    def rates(self, normal_force: Any, relative_velocity: Any, *z: Any) -> dict[str, Any]:
        """The rates of the deflections of elements that stick, m/s."""
        return dict.fromkeys(self.states, relative_velocity)

    def stored_energy(self, normal_force: Any, *z: Any) -> Any:
        """Energy (J) of the springs, the sum of k_i z_i^2/2."""
        return self.k_t * sum(k * one**2 for k, one in zip(self._k, z)) / (2 * sum(self._k))

    def state_limit(self, normal_force: Any) -> dict[str, Any]:
        """The deflections (m) at which the elements slip, F_i/k_i."""
        limit, pairs = self.mu_k * normal_force / self.k_t, zip(self._f, self._k)
        limits = (limit * (f * sum(self._k)) / (k * sum(self._f)) for f, k in pairs)
        return dict(zip(self.states, limits))

    @property
    def _f(self) -> tuple[float, ...]:
        return self.strengths or tuple(range(1, 2 * self.elements, 2))

    @property
    def _k(self) -> tuple[float, ...]:
        return self.stiffnesses or (1,) * self.elements


@dataclass(frozen=True, repr=False)
class RateAndState(FrictionLaw):
    """Rate-and-state friction with Dieterich's aging law: F_T = mu F_N, psi' = (v_0 exp(-psi) - |v_r|)/D_c.

    Here mu = a arsinh(v_r/(2 v_0) exp((mu_0 + b psi)/a)), which is mu_0 + a log(v_r/v_0) + b psi but for
    speeds far below v_0, where that has a pole.  The state psi = log(v_0 theta/D_c) stands for the age of the
    contacts theta, with theta' = 1 - |v_r| theta/D_c.  In steady sliding psi = -log(|v_r|/v_0), and friction
    falls with the speed where b > a.

    A light mass at a low speed is a stiff system, as friction damps it by a F_N/v_r: runs take short steps.
    For 10 s of a mass of 1 kg on a belt they take 90,000 at 1 m/s, 9,000 at 0.1 m/s and more than 400,000 at
    1 mm/s; with ``method="Radau"`` they take 750, 750 and 1,500, in 0.2 to 0.4 s.
    At v_r = 0 the slope of mu over v_r grows like exp(mu_0/a): with mu_0/a of 60, as by default, a run cannot
    pass v_r = 0 slowly, and ends at a cap of its steps or events.

    Parameters
    ----------
    mu_0 : float
        Coefficient of friction in steady sliding at the speed v_0, above 0.
    a, b : float
        Direct effect of the speed and effect of the state, a above 0.
    D_c : float
        Sliding distance over which contacts are renewed, m, above 0.
    v_0 : float
        Reference speed, m/s, above 0.

    References
    ----------
    J. H. Dieterich, Journal of Geophysical Research 84 (1979) 2161-2168; A. Ruina, Journal of Geophysical
    Research 88 (1983) 10359-10370; without a pole: J. R. Rice, N. Lapusta, K. Ranjith, Journal of the
    Mechanics and Physics of Solids 49 (2001) 1865-1898.
    """

    states: ClassVar[tuple[str, ...]] = ("psi",)
    mu_0: float = parameter(
        0.6,
        symbol=r"\mu_0",
        meaning="coefficient of friction at the reference speed",
        exclusive_minimum=0.0,
        range=(0.01, 1.0),
    )
    a: float = parameter(
        0.01, symbol="a", meaning="direct effect of the speed", exclusive_minimum=0.0, range=(0.001, 0.1)
    )
    b: float = parameter(0.015, symbol="b", meaning="effect of the state", minimum=0.0, range=(0.0, 0.1))
    D_c: float = parameter(
        1e-5,
        unit="m",
        symbol=r"D_{\mathrm{c}}",
        meaning="distance over which contacts are renewed",
        exclusive_minimum=0.0,
        range=(1e-7, 1e-2),
        log=True,
    )
    v_0: float = parameter(
        1e-6,
        unit="m/s",
        symbol="v_0",
        meaning="reference speed",
        exclusive_minimum=0.0,
        range=(1e-9, 1.0),
        log=True,
    )

    def force(self, normal_force: Any, relative_velocity: Any, psi: Any) -> Any:
        """Friction force (N) at a state psi."""
        scaled = relative_velocity / (2 * self.v_0) * exp((self.mu_0 + self.b * psi) / self.a)
        return self.a * arcsinh(scaled) * normal_force

    def rates(self, normal_force: Any, relative_velocity: Any, psi: Any) -> dict[str, Any]:
        """The rate of psi, 1/s: contacts age also where they rest."""
        return {self.states[0]: (self.v_0 * exp(-psi) - abs(relative_velocity)) / self.D_c}


@dataclass(frozen=True, repr=False)
class RateAndStateSlip(RateAndState):
    """Rate-and-state friction with Ruina's slip law: the contacts change only where they slide.

    The force is that of :class:`RateAndState`; psi' = -|v_r|/D_c (psi + log(|v_r|/v_0)), that is
    theta' = -(|v_r| theta/D_c) log(|v_r| theta/D_c).  This has no Taylor series at v_r = 0: a run ends where
    v_r comes to zero.

    Parameters
    ----------
    mu_0, a, b, D_c, v_0 : float
        As of :class:`RateAndState`.

    References
    ----------
    A. Ruina, Journal of Geophysical Research 88 (1983) 10359-10370.
    """

    def rates(self, normal_force: Any, relative_velocity: Any, psi: Any) -> dict[str, Any]:
        """The rate of psi, 1/s."""
        speed = abs(relative_velocity)
        return {self.states[0]: -speed / self.D_c * (psi + log(speed / self.v_0))}
