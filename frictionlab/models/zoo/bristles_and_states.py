"""Oscillators with dynamic friction laws: LuGre's bristles, rate and state, Jenkins' and Iwan's elements."""

from __future__ import annotations

from frictionlab.components.dynamic_friction import Iwan, Jenkins, LuGre, RateAndState
from frictionlab.models.library.dry_friction_oscillators import DenHartog, MassOnBelt
from frictionlab.models.library.parameters import not_negative, of_either_sign, positive
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import NO_EQUILIBRIUM, ZooModel


@model
class LuGreOscillator(ZooModel, MassOnBelt):
    """A mass on a belt, held by a spring, with LuGre's friction: the stick-slip example of the law's authors.

    They draw the spring's end with 0.1 m/s over a ground at rest, which is the same.  The numbers are theirs:
    m = 1 kg, k = 2 N/m, sigma_0 = 1e5 N/m, sigma_1 = sqrt(1e5) N s/m, sigma_2 = 0.4 N s/m, 1 N of Coulomb
    and 1.5 N of static friction, v_s = 0.001 m/s.  With N = 1 the law's coefficients are these forces.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, of which there is none by default, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, IEEE Transactions on Automatic Control 40
    (1995) 419-425.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.eigenvalues(fl.LuGreOscillator()).stable
    True
    """

    k: float = positive(2.0, "N/m", "k", "stiffness of the spring")
    v: float = of_either_sign(0.1, 1.0, "m/s", "v", "speed of the belt")
    friction = LuGre(mu_k=1.0, mu_s=1.5, v_s=1e-3, sigma_0=1e5, sigma_1=1e5**0.5, sigma_2=0.4)

    about = "bristles in the place of stick: the first example of the LuGre law"
    reference = "C. Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419-425"


@model
class SpringSlider(ZooModel, MassOnBelt):
    """A block on a fault, drawn by a spring, with rate-and-state friction.

        m x'' + c x' + k x = mu(v - x', psi) N

    Steady sliding at the speed v is stable where the spring is stiffer than

        k_c = ((b - a) N - c v)/D_c (1 + m v^2/((a N + c v) D_c)),

    and loses its stability there by flutter: below it there are slow earthquakes.  The mass is that of a
    laboratory.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, of which there is none by default, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed at which it is drawn, m/s.
    friction : FrictionLaw

    References
    ----------
    J. R. Rice, A. Ruina, Journal of Applied Mechanics 50 (1983) 343-349; A. Ruina, Journal of Geophysical
    Research 88 (1983) 10359-10370.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SpringSlider()
    >>> (change,) = fl.stability_changes(model, "k", bounds=(0.5, 2.0))
    >>> abs(change.value / model.critical_stiffness - 1) < 1e-9
    True
    """

    k: float = positive(0.85, "N/m", "k", "stiffness of the spring")
    N: float = positive(1.0, "N", "N", "normal force")
    v: float = positive(0.1, "m/s", "v", "speed at which it is drawn")
    friction = RateAndState(mu_0=0.6, a=0.05, b=0.08, D_c=0.1, v_0=0.1)

    about = "a block on a fault: earthquakes where the spring is softer than (b - a) N/D_c"
    reference = "J. R. Rice, A. Ruina, J. Applied Mechanics 50 (1983) 343-349"

    @property
    def critical_stiffness(self) -> float:
        """k_c of RateAndState, N/m."""
        law = self.parameters
        damping = self.c * self.v
        falling, rising = (law["b"] - law["a"]) * self.N - damping, law["a"] * self.N + damping
        return falling / law["D_c"] * (1 + self.m * self.v**2 / (rising * law["D_c"]))


@model
class JenkinsOscillator(ZooModel, DenHartog):
    """A driven mass on a spring and a Jenkins element: m x'' + c x' + k x = F cos(Omega t) + F_T.

    The element is a spring k_t that slips at mu_k N.  A motion that goes from -X to X and back takes, in a
    period, the work

        4 mu_k N (X - mu_k N/k_t)

    in it, and none where X is less than mu_k N/k_t.  The numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    F, Omega : float
        Amplitude (N) and angular frequency (rad/s) of the force.
    friction : FrictionLaw

    References
    ----------
    W. D. Iwan, Journal of Applied Mechanics 33 (1966) 893-900.

    Examples
    --------
    >>> import frictionlab as fl
    >>> str(fl.steady_state(fl.JenkinsOscillator(), transient=500.0, progress=False).kind)
    'periodic'
    """

    c: float = not_negative(0.1, 1.0, "N s/m", "c", "damping")
    k: float = positive(1.0, "N/m", "k", "stiffness of the spring")
    N = 1.0
    F: float = not_negative(0.5, 5.0, "N", "F", "amplitude of the force")
    Omega: float = positive(1.0, "rad/s", r"\Omega", "angular frequency of the force")
    friction = Jenkins(mu_k=0.3, k_t=1.0)

    about = "a joint that slips beyond a limit: damping that grows with the amplitude"
    reference = "W. D. Iwan, J. Applied Mechanics 33 (1966) 893-900"
    not_applicable = NO_EQUILIBRIUM


@model
class BoltedJoint(JenkinsOscillator):
    """A driven mass on a spring and a joint that slips little by little: Iwan's element.

        m x'' + c x' + k x = F cos(Omega t) + F_T

    Its n elements slip one after the other: partial slip, then slip of the whole.  A motion that goes from -X
    to X and back takes, in a period, the work

        sum over i of 4 F_i max(X - F_i/k_i, 0)

    in it, with the strength F_i and the stiffness k_i of each element.  The numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    F, Omega : float
        Amplitude (N) and angular frequency (rad/s) of the force.
    friction : FrictionLaw

    References
    ----------
    W. D. Iwan, Journal of Applied Mechanics 33 (1966) 893-900.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.BoltedJoint(), 50.0, progress=False)
    >>> "contact | slip+ | slip+ | stick" in run.events.target
    True
    """

    friction = Iwan(mu_k=0.3, k_t=1.0)

    about = "a joint of several elements, that slips little by little: Iwan's element, and Masing's rule"
