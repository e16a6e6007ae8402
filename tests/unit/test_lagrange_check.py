"""`check_model` sees a flow that is not the one of the energies."""

from __future__ import annotations

from dataclasses import replace

import pytest

import frictionlab as fl
from frictionlab.automaton import HybridAutomaton
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.mechanics import Mechanics
from frictionlab.models.symbols import symbol
from tests.helpers.cases import slow_but


@fl.model
class Dripping(MechanicalModel):
    """A bead on a parabola on a trolley; its mass changes with time, and the flow may lack a term."""

    m: float = fl.parameter(1.0, unit="kg", symbol="m", meaning="mass", range=(0.1, 9.0), exclusive_minimum=0)
    lacking: str = ""
    coordinates = ("x", "y")

    def release(self):
        """Bead to the side, trolley in motion."""
        return {"y": 0.4, "x'": 0.3}

    def mechanics(self, q, v):
        """T of place and time."""
        bead = self.m * (1 + fl.functions.cos(q.phase) / 4)
        kinetic = 2 * v.x**2 / 2 + bead * ((v.x + v.y) ** 2 + (q.y * v.y) ** 2) / 2
        return Mechanics(kinetic, 9.81 * bead * q.y**2 / 2 + q.x**2 / 2, v.x**2 / 20, frequency=2.0)

    def derive(self):
        """The flow, less a part of the first or the second acceleration."""
        whole = super().derive()
        (mode,) = whole.modes
        flow, x, y = list(mode.flow), symbol("x'"), symbol("y'")
        flow[2] -= {"damping": x / 1000}.get(self.lacking, 0)
        flow[3] -= {"time": y * fl.functions.sin(symbol("phase")) / 100, "place": y**2 / 1e4}.get(
            self.lacking, 0
        )
        modes = (replace(mode, flow=tuple(flow)),)
        return HybridAutomaton(whole.states, modes, {}, whole.coordinates)


@pytest.mark.slow
def test_the_flow_of_the_energies_passes():
    fl.testing.check_model(Dripping(), t_end=3.0)


@pytest.mark.parametrize("lacking", slow_but(["place"], ["time", "place", "damping"]))
def test_a_flow_that_lacks_a_term_fails(lacking):
    with pytest.raises(AssertionError, match=r"Lagrange's equation of '[xy]' is not kept"):
        fl.testing.check_model(Dripping(lacking=lacking), t_end=3.0)
