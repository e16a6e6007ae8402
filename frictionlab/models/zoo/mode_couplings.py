"""Mode coupling by friction that does not fall with speed: a mass between two contacts."""

from __future__ import annotations

from typing import Any

from frictionlab.models.library.parameters import natural_period
from frictionlab.models.mechanical.mechanics import Mechanics
from frictionlab.models.mechanism import Belt, Block, Mechanism, Point, Spring
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import ZooModel, not_negative, positive


@model
class HultenOscillator(ZooModel):
    """A mass that two springs with cubic parts press on two belts, and which slides on both for good.

    Each contact's normal force is that of its spring, f_i(x) = k_i x + g_i x^3, and its friction acts along
    the other's:

        m x'' + c1 x' + f_1(x) - mu f_2(y) = 0
        m y'' + c2 y' + f_2(y) + mu f_1(x) = 0

    Without dampers both modes coalesce at

        mu_c = |k1 - k2|/(2 sqrt(k1 k2)),      omega_c^2 = (k1 + k2)/(2 m).

    With dampers flutter sets in at a mu that depends on their ratio: the damper of one mode may lower it.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c1, c2 : float
        Dampers, N s/m.
    k1, k2 : float
        Springs, N/m.
    g1, g2 : float
        Cubic parts of the springs, N/m^3.
    mu : float
        Coefficient of friction.

    References
    ----------
    J. Hulten, SAE Technical Paper 932965 (1993), for the linear system; with cubic parts J.-J. Sinou,
    L. Jezequel, European Journal of Mechanics A/Solids 26 (2007) 106-122.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.HultenOscillator(c1=0.0, c2=0.0)
    >>> abs(fl.critical_value(model, "mu", bounds=(0, 1)) - model.critical_friction) < 1e-9
    True
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c1: float = not_negative(0.02, 1.0, "N s/m", "c_1", "damping along x")
    c2: float = not_negative(0.02, 1.0, "N s/m", "c_2", "damping along y")
    k1: float = positive(1.5, "N/m", "k_1", "stiffness along x")
    k2: float = positive(1.0, "N/m", "k_2", "stiffness along y")
    g1: float = not_negative(1.0, 10.0, "N/m^3", "g_1", "cubic stiffness along x")
    g2: float = not_negative(0.0, 10.0, "N/m^3", "g_2", "cubic stiffness along y")
    mu: float = not_negative(0.25, 1.0, "", r"\mu", "coefficient of friction")
    coordinates = ("x", "y")

    about = "two modes that friction couples, with a limit cycle by cubic springs alone"
    reference = "J.-J. Sinou, L. Jezequel, European J. Mechanics A/Solids 26 (2007) 106-122"

    @property
    def period(self) -> float:
        """That of the mass on the first spring, s."""
        return natural_period(self.k1, self.m)

    @property
    def critical_friction(self) -> float:
        """mu_c, at which undamped modes coalesce."""
        return abs(self.k1 - self.k2) / (2 * (self.k1 * self.k2) ** 0.5)

    def release(self) -> dict[str, float]:
        """Beside the equilibrium, which is at rest."""
        return {"x": 0.1}

    @property
    def mechanism(self) -> Mechanism:
        """A mass on a belt below it and one beside it, drawn as two springs."""
        body = Point(0.0, 0.8, right="x", up="y")
        below, beside = (
            Spring(Point(0.0, 0.0), body.beside(0.0, -0.2)),
            Spring(Point(-1.2, 0.8), body.beside(-0.3)),
        )
        return Mechanism(Belt(start=-0.9), below, beside, Block(body))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass; friction as loads, as it never reverses."""
        first, second = self.k1 * q.x + self.g1 * q.x**3, self.k2 * q.y + self.g2 * q.y**3
        linear, cubic = (self.k1 * q.x**2 + self.k2 * q.y**2) / 2, (self.g1 * q.x**4 + self.g2 * q.y**4) / 4
        dampers = (self.c1 * v.x**2 + self.c2 * v.y**2) / 2
        rubbing = {"x": self.mu * second, "y": -self.mu * first}
        return Mechanics(self.m * (v.x**2 + v.y**2) / 2, linear + cubic, dampers, loads=rubbing)
