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
