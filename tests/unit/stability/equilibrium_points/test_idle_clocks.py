"""Equilibria where a phase or the time moves nothing: closed forms of the system without it."""

import numpy as np
import pytest

import frictionlab as fl

cos, sin = fl.functions.cos, fl.functions.sin


@fl.model
class ShakenMass(fl.MechanicalModel):
    """A mass of 2 kg on a table that vibrates; a belt rubs on it, and a load grows."""

    F: float = 0.0
    A: float = 0.0
    rate: float = 0.0
    Omega: float = 3.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        table = fl.Stop(
            q.y - self.A * sin(q.phase),
            fl.PlasticImpact(),
            friction=self.friction,
            relative_velocity=1.0 - v.x,
        )
        loads = {"x": self.F * cos(q.phase) * q.x**2 + self.rate * q.t}
        energy = 20.0 * q.y + 5.0 * q.x**2 / 2
        frequency = self.Omega
        return fl.Mechanics(
            v.x**2 + v.y**2, energy, v.x**2 / 2, loads=loads, contacts=(table,), frequency=frequency
        )


@pytest.mark.parametrize("changes", [{}, {"Omega": 0.0}, {"A": 0.1, "Omega": 0.0}], ids=str)
def test_a_phase_that_moves_nothing_or_stands_leaves_the_equilibrium(changes):
    model = ShakenMass(**changes)
    (only,) = fl.equilibria(model)
    assert (*only.q, only.normal_force) == pytest.approx((0.3 * 20.0 / 5.0, 0.0, 20.0), abs=1e-14)
    expected = np.roots([2.0, 1.0, 5.0])
    np.testing.assert_allclose(fl.eigenvalues(model).values, expected[[1, 0]], rtol=1e-14)


@pytest.mark.parametrize("name", ["F", "A", "rate"])
def test_what_depends_on_a_phase_or_a_time_has_no_equilibrium(name):
    values = [getattr(ShakenMass(), name), 2.0]
    known = np.isfinite(fl.root_locus(ShakenMass(), name, values).values).all(axis=1)
    assert known.tolist() == [True, False]
    with pytest.raises(ValueError, match=r"phase never rests|depend on the time"):
        fl.equilibrium(ShakenMass(**{name: 2.0}))
