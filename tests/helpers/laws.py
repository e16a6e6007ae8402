"""Laws of users, for tests."""

from dataclasses import dataclass

import frictionlab as fl


@dataclass(frozen=True)
class Locking(fl.ContactLaw):
    """A contact that stiffens towards a penetration, with a pole there and at the gap opposite."""

    k: float = 5e3
    most: float = 0.1

    def force(self, penetration):
        """Without bound at the pole."""
        return self.k * penetration / (1 - (penetration / self.most) ** 2)


@dataclass(frozen=True, repr=False)
class Undefined(fl.Coulomb):
    """A user's law that is no number at any speed, or none at those above a limit."""

    limit: float = 1.5

    def kinetic(self, normal_force, speed):
        return normal_force * (fl.functions.log(self.limit - speed) if self.limit else float("nan"))


@dataclass(frozen=True)
class Saturating(fl.ContactLaw):
    """A contact law that is no polynomial."""

    stiff: float = 5e3
    top: float = 300.0

    def force(self, penetration):
        """Levels off."""
        linear = self.stiff * penetration
        return self.top * linear / (self.top**2 + linear**2) ** 0.5


@dataclass(frozen=True)
class Circle(fl.FrictionLaw):
    """Its state settles below a speed of 1 alone."""

    rate: float = fl.parameter(1.0)
    states = ("z", "w")

    def force(self, F_N, v, z, w):
        """By both states."""
        return (0.1 * z + w) * F_N

    def rates(self, F_N, v, z, w):
        """Zero where z^2 is 1 - v^2."""
        return {"z": self.rate * (1.0 - v**2 - z**2), "w": self.rate * (0.1 * z - w)}
