"""Oscillators on a belt: falling friction, a base that moves, rows of masses, a belt that brakes, noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import pi
from random import Random
from types import MappingProxyType
from typing import Any

import numpy as np

from frictionlab.components.friction import (
    Coulomb,
    ExponentialDecay,
    FrictionLaw,
    HyperbolicDecay,
    WeakeningStrengthening,
)
from frictionlab.components.functions import cos, ramp
from frictionlab.models.library.dry_friction_oscillators import MassOnBelt
from frictionlab.models.library.parameters import natural_period, not_negative, of_either_sign, positive
from frictionlab.models.mechanical.mechanical_model import numbered
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Belt, Block, Forces, Mechanism, Point, Spring, Wall, level_belt
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import NO_EQUILIBRIUM, UNBOUNDED, ZooModel, of_what_ends
from frictionlab.validation import check_number


@model
class PoppStelter(ZooModel, MassOnBelt):
    """A mass on a belt with friction that falls as a hyperbola: m x'' + c x' + k x = F_T.

    The slope of the friction curve is a negative damper.  Steady sliding is stable where the belt is faster
    than

        v_H = v_s (sqrt((mu_s - mu_k) N/(c v_s)) - 1),

    and loses its stability there at the angular frequency sqrt(k/m).  Hyperbolas of this kind are those of
    Popp and Stelter; the numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89-105.

    Examples
    --------
    >>> import frictionlab as fl
    >>> (change,) = fl.stability_changes(fl.PoppStelter(), "v", bounds=(0.2, 5.0))
    >>> abs(change.value - 0.5 * (10**0.5 - 1)) < 1e-9
    True
    """

    c = 0.1
    k: float = positive(1.0, "N/m", "k", "stiffness of the spring")
    v = 0.5
    friction = HyperbolicDecay(mu_k=0.5, mu_s=1.0, v_s=0.5)

    about = "friction that falls as a hyperbola: steady sliding above a belt speed, stick-slip below it"
    reference = "K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89-105"
    not_applicable = UNBOUNDED


@model
class WeakeningOscillator(PoppStelter):
    """A mass on a belt with friction that weakens and then strengthens: stick-slip beside stable sliding.

    Steady sliding is stable where the belt is faster than

        v_H = v_s log((mu_s - mu_k) N/(mu_v N + c v_s)),

    0.602 m/s here.  The Hopf point there is subcritical: up to a fold above it stick-slip lasts beside stable
    sliding, and where the motion begins decides.  By default the belt is between both, and the motion that
    begins at rest is stick-slip.  On a belt of 1 m/s, above the fold, there is none.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    A. Papangelo, M. Ciavarella, N. Hoffmann, Nonlinear Dynamics 90 (2017) 2037-2046.

    Examples
    --------
    >>> import math
    >>> import frictionlab as fl
    >>> point = fl.hopf(fl.WeakeningOscillator(), "v", bounds=(0.3, 1.0))
    >>> abs(point.value - 0.5 * math.log(0.5 / 0.15)) < 1e-9, point.criticality
    (True, 'subcritical')
    """

    v = 0.65
    friction = WeakeningStrengthening(mu_k=0.5, mu_s=1.0)

    about = "friction that weakens, then strengthens: stick-slip beside stable sliding"
    reference = "A. Papangelo, M. Ciavarella, N. Hoffmann, Nonlinear Dynamics 90 (2017) 2037-2046"


@model
class ExcitedBeltOscillator(PoppStelter):
    """A mass on a belt whose spring hangs on a base that moves: m x'' + c x' + k (x - u cos(Omega t)) = F_T.

    As long as the mass slides without stick on a faster belt, Coulomb's friction is a constant force.  With
    r = Omega/sqrt(k/m) and D = c/(2 sqrt(k m)) the amplitude is then that of the linear oscillator,

        u/sqrt((1 - r^2)^2 + (2 D r)^2).

    On a slower belt it sticks, with motions of one, two and more periods of the base, and chaos.  The system
    is that of Hinrichs, Oestreich and Popp; the numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    u, Omega : float
        Amplitude (m) and angular frequency (rad/s) of the base.
    friction : FrictionLaw

    References
    ----------
    N. Hinrichs, M. Oestreich, K. Popp, Journal of Sound and Vibration 216 (1998) 435-459.

    Examples
    --------
    >>> import frictionlab as fl
    >>> import numpy as np
    >>> model = fl.ExcitedBeltOscillator(v=3.0)
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 200.0, progress=False))
    >>> swing = orbit.trajectory(np.linspace(0.0, orbit.period, 1001))[:, 0]
    >>> bool(abs(swing.max() - 0.5 - 0.5 / np.hypot(0.75, 0.05)) < 1e-4)
    True
    """

    v = 0.3
    u: float = not_negative(0.5, 2.0, "m", "u", "amplitude of the base")
    Omega: float = positive(0.5, "rad/s", r"\Omega", "angular frequency of the base")
    friction = Coulomb(mu_k=0.5, mu_s=0.8)

    about = "a base that moves beside a belt that runs: linear while it slides, stick-slip and chaos below"
    reference = "N. Hinrichs, M. Oestreich, K. Popp, J. Sound and Vibration 216 (1998) 435-459"
    not_applicable = NO_EQUILIBRIUM

    @property
    def period(self) -> float:
        """That of the base, s."""
        return 2 * pi / self.Omega

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The spring's end moves."""
        stretch = q.x - self.u * cos(q.phase)
        return replace(super().mechanics(q, v), potential=self.k * stretch**2 / 2, frequency=self.Omega)


@model
class OscillatorChain(PoppStelter):
    """A ring of equal masses on a belt, each with a spring of its own and one to either neighbour.

        m x_i'' + c x_i' + k x_i + k_c (2 x_i - x_(i-1) - x_(i+1)) = F_Ti

    Where friction falls with speed a part of the masses may vibrate while the others slide: there are many
    steady states beside steady sliding.  About the latter each of the n waves has

        lambda^2 + (c + N mu'(v))/m lambda + (k + 4 k_c sin^2(pi j/n))/m = 0,   j = 0, ..., n - 1,

    so that all lose their stability at one speed of the belt.  The numbers are this package's.

    Parameters
    ----------
    m : float
        Masses, kg, above 0.
    c, k, k_c : float
        Damper (N s/m) and spring (N/m) of each mass, springs between neighbours.
    N : float
        Normal force on each mass, N.
    v : float
        Speed of the belt, m/s.
    masses : int
        n.
    friction : FrictionLaw

    References
    ----------
    A. Papangelo, N. Hoffmann, A. Grolet, M. Stender, M. Ciavarella, Journal of Sound and Vibration 417 (2018)
    56-64.

    Examples
    --------
    >>> import frictionlab as fl
    >>> values = fl.eigenvalues(fl.OscillatorChain()).values
    >>> (abs(values) ** 2).round(9).tolist()  # k/m, and twice (k + 3 k_c)/m
    [1.0, 1.0, 1.6, 1.6, 1.6, 1.6]
    """

    k_c: float = not_negative(0.2, 2.0, "N/m", r"k_{\mathrm{c}}", "stiffness between neighbours")
    v = 0.9
    friction = ExponentialDecay(mu_k=0.5, mu_s=1.0, v_s=0.5)
    masses: int = 3
    coordinates = numbered("x", count="masses")

    about = "a ring of masses on a belt: one, some or all of them vibrate"
    reference = "A. Papangelo et al., J. Sound and Vibration 417 (2018) 56-64"

    def release(self) -> Mapping[str, float]:
        """The first mass aside, as from rest all would move as one."""
        return {"x1": 1.0}

    @property
    def mechanism(self) -> Mechanism:
        """Blocks in a row on a belt, with springs between them."""
        places = [Point(1.4 * i, 0.2, right=name) for i, name in enumerate(self.coordinates)]
        between = [Spring(a.beside(0.3), b.beside(-0.3)) for a, b in pairwise(places)]
        forces = [Forces(at, f"_{i + 1}" if self.masses > 1 else "") for i, at in enumerate(places)]
        belt = level_belt("v", -0.8, 1.4 * self.masses - 0.6)
        return Mechanism(belt, *between, *map(Block, places), *forces)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """n masses, n contacts."""
        x, u = np.array(q), np.array(v)
        springs = self.k * sum(x**2) + self.k_c * sum((x - np.roll(x, 1)) ** 2)
        rubbing = tuple(Friction(self.v - rate, self.N, self.friction) for rate in v)
        return Mechanics(self.m * sum(u**2) / 2, springs / 2, self.c * sum(u**2) / 2, rubbing)


@model
class DitheredOscillator(ZooModel, MassOnBelt):
    """A mass on springs on a belt that vibrates across its way: friction in the plane, with v_r = (a, b).

        m x'' + c x' + k x = mu N a/|v_r|,  a = v - x'
        m y'' + c y' + k y = mu N b/|v_r|,  b = w cos(Omega t) - y'

    Only the share a/|v_r| of the friction force is along the belt.  Where the vibration is so quick that
    the mass does not follow, its mean is, with r = w/v and the complete elliptic integral K of a modulus,

        2/(pi sqrt(1 + r^2)) K(r/sqrt(1 + r^2)) mu_k N,

    and stick-slip ends.  The effect is that of ultrasonic vibrations, which by the abstract of Storck and
    others Coulomb's law describes very well, along the motion and across it; the paper itself could not be
    read.  The model, its mean and the numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper (N s/m) and springs (N/m, above 0) in both directions.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    w, Omega : float
        Speed (m/s) and angular frequency (rad/s) of its vibration across.
    friction : FrictionLaw

    References
    ----------
    H. Storck, W. Littmann, J. Wallaschek, M. Mracek, Ultrasonics 40 (2002) 379-383,
    doi:10.1016/S0041-624X(02)00126-9.

    Examples
    --------
    >>> import frictionlab as fl
    >>> calm, dithered = (fl.simulate(fl.DitheredOscillator(w=w), 60.0, progress=False) for w in (0.0, 1.0))
    >>> "stick" in calm.events.target, "stick" in dithered.events.target
    (True, False)
    """

    k: float = positive(1.0, "N/m", "k", "stiffness of the springs in both directions")
    v = 0.3
    w: float = of_either_sign(0.5, 3.0, "m/s", "w", "speed of the belt's vibration across")
    Omega: float = positive(6.0, "rad/s", r"\Omega", "angular frequency of the vibration")
    friction = Coulomb(mu_k=0.4, mu_s=0.8)
    coordinates = ("x", "y")

    about = "a belt that vibrates across its way: less friction along it, and no stick-slip"
    reference = "H. Storck et al., Ultrasonics 40 (2002) 379-383"
    not_applicable = NO_EQUILIBRIUM

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact in the plane."""
        rubbing = Friction((self.v - v.x, self.w * cos(q.phase) - v.y), self.N, self.friction)
        square, springs = v.x**2 + v.y**2, self.k * (q.x**2 + q.y**2) / 2
        return Mechanics(self.m * square / 2, springs, self.c * square / 2, (rubbing,), frequency=self.Omega)


@model
class DoubleLayerPad(ZooModel):
    """A brake pad of two layers, of which the lower one rubs on the disc; the disc is a belt.

        m1 x1'' + c1 (x1' - x2') + k1 (x1 - x2) = F_T
        m2 x2'' + c1 (x2' - x1') + c2 x2' + k1 (x2 - x1) + k2 x2 = 0

    Both layers vibrate together, or against each other.  The system is of the kind of Wei and others; the
    numbers are this package's.

    Parameters
    ----------
    m1, m2 : float
        Masses of the lower and the upper layer, kg, above 0.
    c1, k1 : float
        Damper (N s/m) and spring (N/m) between the layers.
    c2, k2 : float
        Damper and spring of the upper layer.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    D. Wei, J. Song, Y. Nan, W. Zhu, Mechanical Systems and Signal Processing 118 (2019).

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.steady_state(fl.DoubleLayerPad(), progress=False).kind
    'periodic'
    """

    m1: float = positive(1.0, "kg", "m_1", "mass of the lower layer")
    m2: float = positive(1.0, "kg", "m_2", "mass of the upper layer")
    c1: float = not_negative(0.05, 1.0, "N s/m", "c_1", "damping between the layers")
    c2: float = not_negative(0.05, 1.0, "N s/m", "c_2", "damping of the upper layer")
    k1: float = positive(2.0, "N/m", "k_1", "stiffness between the layers")
    k2: float = positive(1.0, "N/m", "k_2", "stiffness of the upper layer's spring")
    N: float = not_negative(1.0, 10.0, "N", "N", "normal force")
    v: float = of_either_sign(0.4, 3.0, "m/s", "v", "speed of the belt")
    friction: FrictionLaw = ExponentialDecay(mu_k=0.3, mu_s=0.6, v_s=0.5)
    coordinates = ("x1", "x2")

    about = "a pad of two layers on a belt: two modes that falling friction feeds"
    reference = "D. Wei, J. Song, Y. Nan, W. Zhu, Mech. Systems and Signal Processing 118 (2019)"
    not_applicable = UNBOUNDED

    @property
    def period(self) -> float:
        """That of both layers on the upper spring, s."""
        return natural_period(self.k2, self.m1 + self.m2)

    @property
    def mechanism(self) -> Mechanism:
        """Two blocks on each other, each with a spring at its side."""
        lower, upper = Point(0.0, 0.2, right="x1"), Point(0.0, 0.8, right="x2")
        between = Spring(lower.beside(0.3, 0.1), upper.beside(0.3, -0.1))
        held = Spring(Point(-1.6, 0.8), upper.beside(-0.3)), Wall((-1.6, 0.5), (-1.6, 1.1))
        return Mechanism(Belt("v"), *held, between, Block(lower), Block(upper), Forces(lower))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two masses, one contact."""
        rubbing = Friction(self.v - v.x1, self.N, self.friction)
        springs = (self.k1 * (q.x1 - q.x2) ** 2 + self.k2 * q.x2**2) / 2
        dampers = (self.c1 * (v.x1 - v.x2) ** 2 + self.c2 * v.x2**2) / 2
        kinetic = (self.m1 * v.x1**2 + self.m2 * v.x2**2) / 2
        return Mechanics(kinetic, springs, dampers, contacts=(rubbing,))


@model
class BrakedOscillator(PoppStelter):
    """A mass on a belt that brakes to a halt: m x'' + c x' + k x = F_T, with the speed v (1 - t/t_b).

    A brake squeals at the end of a stop: friction that falls with speed has its steepest slope where the belt
    is slow.  With time frozen the eigenvalues are those of the belt's speed at that time, and steady sliding
    loses its stability where c + N mu'(v (1 - t/t_b)) = 0.  The system is of the kind of Pilipchuk, Olejnik
    and Awrejcewicz, with one freedom; the numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt at first, m/s.
    t_b : float
        Time in which it stops, s.
    friction : FrictionLaw

    References
    ----------
    V. Pilipchuk, P. Olejnik, J. Awrejcewicz, Journal of Sound and Vibration 344 (2015) 297-312.

    Examples
    --------
    >>> import frictionlab as fl
    >>> str(fl.simulate(fl.BrakedOscillator(), 120.0).mode[-1])
    'stick | t > t_b'
    """

    v: float = of_either_sign(2.0, 5.0, "m/s", "v", "speed of the belt at first")
    t_b: float = positive(100.0, "s", r"t_{\mathrm{b}}", "time in which it stops")

    about = "a belt that brakes: silence, then a squeal before it stops"
    reference = "V. Pilipchuk, P. Olejnik, J. Awrejcewicz, J. Sound and Vibration 344 (2015) 297-312"
    not_applicable = MappingProxyType(
        {
            **UNBOUNDED,
            **of_what_ends(
                "The belt comes to a halt: its speed depends on time, and no motion goes on for ever."
            ),
        }
    )

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The belt's speed is a ramp."""
        rubbing = Friction(ramp(q.t, self.v, 0, self.t_b) - v.x, self.N, self.friction)
        return replace(super().mechanics(q, v), contacts=(rubbing,))


@model
class ModularChain(OscillatorChain):
    """A ring of equal modules on a belt: in each a mass that rubs, on a mass that its neighbours hold.

        m u_i'' + c u_i' + k (u_i - w_i) = F_Ti
        m_w w_i'' + c w_i' + k (w_i - u_i) + k_w w_i + k_c (2 w_i - w_(i-1) - w_(i+1)) = 0

    About steady sliding each of the n waves is a system of two freedoms, whose second mass has the stiffness
    k_w + 4 k_c sin^2(pi j/n).  The system is of the kind of Brunetti and others; its equations and numbers
    are this package's.

    Parameters
    ----------
    m, m_w : float
        Masses that rub and that are linked, kg, above 0.
    c : float
        Damping of each mass, N s/m.
    k, k_w, k_c : float
        Springs between the masses of a module, of the second one and between neighbours, N/m.
    N : float
        Normal force on each module, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw
    masses : int
        n.

    References
    ----------
    J. Brunetti, F. Massi, W. D'Ambrogio, Y. Berthier, Meccanica 50 (2015) 633-647.

    Examples
    --------
    >>> import frictionlab as fl
    >>> len(fl.eigenvalues(fl.ModularChain()).values)
    8
    """

    m_w: float = positive(2.0, "kg", r"m_{\mathrm{w}}", "mass that is linked")
    k_w: float = positive(1.0, "N/m", r"k_{\mathrm{w}}", "stiffness of the linked mass")
    v = 0.5
    masses = 2
    coordinates = numbered("u", "w", count="masses")

    about = "modules of two masses in a ring on a belt: waves of two freedoms"
    reference = "J. Brunetti, F. Massi, W. D'Ambrogio, Y. Berthier, Meccanica 50 (2015) 633-647"

    def release(self) -> Mapping[str, float]:
        """The first mass aside, as from rest all modules would move as one."""
        return {"u1": 1.0}

    @property
    def period(self) -> float:
        """That of both masses of a module together, s."""
        return natural_period(self.k_w, self.m + self.m_w)

    @property
    def mechanism(self) -> Mechanism:
        """Modules in a row on a belt: the masses that rub below, the linked ones above."""
        n = self.masses
        lower = [Point(1.4 * i, 0.2, right=f"u{i + 1}") for i in range(n)]
        upper = [Point(1.4 * i, 1.0, right=f"w{i + 1}") for i in range(n)]
        within = [Spring(a.beside(0.0, 0.2), b.beside(0.0, -0.2)) for a, b in zip(lower, upper, strict=True)]
        between = [Spring(a.beside(0.3), b.beside(-0.3)) for a, b in pairwise(upper)]
        forces = [Forces(at, f"_{i + 1}" if n > 1 else "") for i, at in enumerate(lower)]
        bodies = map(Block, (*lower, *upper))
        return Mechanism(level_belt("v", -0.8, 1.4 * n - 0.6), *within, *between, *bodies, *forces)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """2 n masses, n contacts."""
        (u, w), (du, dw) = np.reshape(q, (2, -1)), np.reshape(v, (2, -1))
        springs = self.k * sum((u - w) ** 2) + self.k_w * sum(w**2) + self.k_c * sum((w - np.roll(w, 1)) ** 2)
        rubbing = tuple(Friction(self.v - rate, self.N, self.friction) for rate in du)
        kinetic = self.m * sum(du**2) + self.m_w * sum(dw**2)
        return Mechanics(kinetic / 2, springs / 2, self.c * sum(rate**2 for rate in v) / 2, rubbing)


@model
class NoisyOscillator(PoppStelter):
    """A mass on a belt under noise: a force of many sines of equal size on the harmonics of one frequency.

        m x'' + c x' + k x = F_T + a sqrt(2/n) sum_(j=1..n) cos(j Omega t + p_j)

    The phases p_j are drawn by `seed`; the force has the root mean square a, and repeats after 2 pi/Omega.
    While the mass slides on a faster belt, Coulomb's friction is a constant, and the mean square of x about
    its mean is that of the linear oscillator,

        a^2/n sum_j 1/((k - m (j Omega)^2)^2 + (c j Omega)^2).

    The solver has no stochastic equations: this is one sample of noise with a spectrum of lines.  The system
    and its numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    a, Omega : float
        Root mean square of the noise (N), and its lowest angular frequency (rad/s).
    friction : FrictionLaw
    sines, seed : int
        n, and what the phases are drawn by.

    References
    ----------
    X. Sui, Q. Ding, Applied Mathematics and Mechanics (2019), for noise on a pad on a disc.
    S. O. Rice, Bell System Technical Journal 23 (1944) 282-332, for noise as a sum of sines.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.NoisyOscillator(v=20.0)
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 400.0, progress=False))
    >>> round(orbit.period * model.Omega, 9)  # 2 pi
    6.283185307
    """

    v: float = of_either_sign(0.3, 5.0, "m/s", "v", "speed of the belt")
    a: float = not_negative(0.3, 2.0, "N", "a", "root mean square of the noise")
    Omega: float = positive(0.1, "rad/s", r"\Omega", "lowest angular frequency of the noise")
    friction = Coulomb(mu_k=0.5, mu_s=0.8)
    sines: int = 20
    seed: int = 1

    about = "noise as many sines on the harmonics of the phase: how much of it friction takes"
    reference = "S. O. Rice, Bell System Technical J. 23 (1944) 282-332"
    not_applicable = NO_EQUILIBRIUM

    def check(self) -> None:
        """`sines` is from 1 to 100, `seed` at least 0."""
        self.check_count("sines", least=1)
        check_number("seed", self.seed, integer=True, least=0)
        super().check()

    def phases(self) -> list[float]:
        """p_j, rad."""
        draw = Random(self.seed)
        return [draw.uniform(0.0, 2 * pi) for _ in range(self.sines)]

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact, n sines."""
        noise = sum(cos(j * q.phase + p) for j, p in enumerate(self.phases(), 1))
        loads = {"x": self.a * (2 / self.sines) ** 0.5 * noise}
        return replace(super().mechanics(q, v), loads=loads, frequency=self.Omega)
