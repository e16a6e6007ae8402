"""The energy balance: it closes, and every term is what mechanics says it is."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import trapezoid

import frictionlab as fl
from frictionlab.components import SlidingOnly, StickSlip
from frictionlab.plotting.overview import plot_works
from tests.helpers.cases import slow_but

USUAL = fl.SliderOnBelt(mu_k=1.4)
NORMAL = USUAL.replace(geometry=fl.MovingLoad(direction="normal"))
UNDAMPED = dict.fromkeys(("c1", "c2", "c4", "c5", "c6"), 0.0)
SMOOTH = dict.fromkeys(("mu_k", "mu_s"), 0.0)
OFF = [names for k in range(4) for names in combinations(("cubic", "nonsmooth", "geometry"), k)]
SCENES = {
    "A": USUAL.without("geometry"),
    "B": USUAL.replace(impact=fl.PlasticImpact("full")),
    "C": fl.SliderOnBelt(mu_k=2.5, k_nl=1e7, F=800.0, k4=5e6, k5=5e6, k6=5e6).without("nonsmooth"),
    "D": USUAL,
    **{f"without {names}": fl.SliderOnBelt(mu_k=0.6).without(*names) for names in OFF},
    "restitution 0.5": USUAL.replace(impact=fl.RestitutionImpact(0.5)),
    "restitution 1": USUAL.replace(impact=fl.RestitutionImpact(1.0)).without("geometry"),
    "bilateral": USUAL.replace(interface=StickSlip()),
    "normal": NORMAL,
}


def run_of(model, t_end=1.0, **options):
    return fl.simulate(model, t_end, progress=False, **options)


OFTEN = [name for name in SCENES if name not in {f"without {names}" for names in OFF[1:]}]


@pytest.mark.parametrize("name", slow_but(OFTEN, SCENES))
def test_the_balance_closes(name):
    audit = fl.energy_audit(run_of(SCENES[name]))
    assert audit.turned_over > 10.0
    assert audit.error < 1e-13
    assert np.abs(audit.residual).max() == pytest.approx(audit.error * audit.turned_over)


def with_powers(automaton):
    """The automaton with the powers of friction as outputs."""

    def also(mode):
        out = mode.outputs
        drive = out["friction_force"] * sp.Symbol("v", real=True)
        rubbed = -out["friction_force"] * out["relative_velocity"]
        return replace(mode, outputs={**out, "belt drive": drive, "friction": rubbed})

    return replace(automaton.derived(), modes=tuple(map(also, automaton.modes)))


@pytest.mark.parametrize("name", slow_but(["B", "bilateral"], ["A", "B", "D", "bilateral"]))
def test_works_are_those_of_quadratures(name):
    model = SCENES[name]
    contributions = {"belt drive": "belt drive", "friction": "friction"}
    start = np.zeros(2 * len(model.coordinates))
    run = fl.solve(
        with_powers(model.automaton()), 1.0, x0=start, quadratures=contributions, source=model, progress=False
    )
    works = fl.energy_audit(run).works
    for contribution in contributions:
        assert works[contribution][-1] == pytest.approx(run.quadratures[contribution], rel=1e-12)


def test_friction_is_what_the_belt_drive_pays_at_rest_in_steady_sliding():
    model = USUAL.replace(mu_k=0.3).without("geometry")
    at = fl.equilibrium(model)
    run = run_of(model, 2.0, x0=[*at.q, 0, 0, 0, 0])
    audit = fl.energy_audit(run)
    assert audit.powers["belt drive"] == pytest.approx(np.full(len(run.t), at.friction_force * model.v))
    assert audit.works["belt drive"][-1] == pytest.approx(2.0 * at.friction_force * model.v, rel=1e-12)
    assert audit.works["friction"] == pytest.approx(-audit.works["belt drive"], abs=1e-11)
    assert audit.energies["kinetic"] == pytest.approx(0.0, abs=1e-25)
    p, gap = model, at.penetration
    assert audit.energies["contact"][0] == pytest.approx(p.k2 * gap**2 / 2 + p.k_nl * gap**4 / 4, rel=1e-14)
    assert audit.energies["preload"][0] == pytest.approx(p.F * at.q[1], rel=1e-14)


def test_signs():
    """Friction and dampers only take; stick takes nothing; plastic impacts take at each."""
    run = run_of(SCENES["A"], 3.0)
    audit = fl.energy_audit(run)
    assert (audit.powers["friction"] <= 1e-12).all()
    assert (audit.powers["dampers"] <= 0).all()
    assert np.abs(audit.powers["friction"][run.mode == "stick"]).max() < 1e-11
    flight = run.mode == "separation"
    assert not audit.energies["contact"][flight].any()
    assert not audit.powers["belt drive"][flight].any()
    assert (np.diff(audit.works["impacts"]) < 1e-12).all()
    assert audit.works["impacts"][-1] < -1.0


def test_an_impact_takes_what_the_approach_had():
    """Plastic: (gap rate)^2/(2 compliance), and 1 - e^2 of it with restitution."""
    for e in (0.0, 0.5, 0.8):
        run = run_of(USUAL.replace(impact=fl.RestitutionImpact(e)).without("geometry"), 0.5)
        landed = run.events.source == "separation"
        before = run.events.before[landed]
        rate, compliance = before[:, 7] - before[:, 5], 1 / USUAL.M + 1 / USUAL.m
        taken = (1 - e**2) * rate**2 / (2 * compliance)
        assert len(taken) > 3
        works = fl.energy_audit(run).works["impacts"]
        assert works[-1] == pytest.approx(-taken.sum(), rel=1e-11)


def test_the_moving_load_does_the_work_of_erratum_e4():
    """-F_N phi (x1' - x2'), by trapezoids."""
    model = USUAL.replace(interface=SlidingOnly(), **SMOOTH, **UNDAMPED)
    t = np.linspace(0.0, 1.0, 20_001)
    run = run_of(model, 1.0, t_eval=t, x0=[0.01, -0.02, -0.01, 0.0, 0.05, 0.5, 0, 0, 0, 0])
    audit = fl.energy_audit(run)
    power = -run["normal_force"] * run["phi"] * (run["x1'"] - run["x2'"])
    assert audit.powers["moving load"] == pytest.approx(power, abs=1e-12)
    assert audit.works["moving load"][-1] == pytest.approx(trapezoid(power, t), abs=1e-5)
    assert np.ptp(audit.total) > 0.1
    assert np.ptp(audit.total - audit.works["moving load"]) < 1e-12


@pytest.mark.parametrize("interface", [SlidingOnly(), fl.StickSlipSeparation()])
def test_a_force_normal_to_the_belt_keeps_the_energy(interface):
    """No friction, no dampers, elastic impacts: nothing comes or goes, and none of the parts is at rest."""
    model = NORMAL.replace(interface=interface, impact=fl.RestitutionImpact(1.0), v=1.0, **SMOOTH, **UNDAMPED)
    run = run_of(model, 2.0, x0=[0.01, -0.02, -0.01, 0.0, 0.05, 0.5, 0, 0, 0, 0])
    audit = fl.energy_audit(run)
    assert not audit.works["moving load"].any()
    assert np.ptp(audit.energies["contact"]) > 0.1
    assert np.ptp(audit.total) < 1e-12 * audit.turned_over


def test_a_normal_force_acts_along_the_gradient_of_the_gap():
    q = sp.symbols("x1 y1 x2 y2 phi")
    geometry = fl.MovingLoad(direction="normal")
    penetration = geometry.penetration(*q)
    assert [sp.expand(w + sp.diff(penetration, x)) for w, x in zip(geometry.normal(*q), q)] == [0] * 5
    vertical = fl.MovingLoad()
    assert vertical.normal(*q) == (0, 1, 0, -1, q[0] - q[2])
    assert vertical == fl.MovingLoad("vertical")
    with pytest.raises(ValueError, match="direction must be one of 'vertical', 'normal', got 'norml'"):
        fl.MovingLoad("norml")


@pytest.mark.slow
def test_a_normal_force_has_no_chatter_and_its_statics_are_those_of_its_automaton():
    assert NORMAL.automaton().names == ("stick", "slip+", "slip-", "separation")
    model = NORMAL.replace(mu_k=0.3)
    at, numerically = fl.equilibrium(model), fl.eigenvalues(model.automaton())
    assert at.residual < 1e-13
    still = run_of(model, 1.0, x0=[*at.q, *np.zeros(5)])
    assert np.abs(still.final_state[:5] - at.q).max() < 1e-14
    found = fl.eigenvalues(model).values
    assert np.abs(found - numerically.values).max() < 1e-9


def test_other_methods_are_audited_as_they_are():
    coarse, fine = (fl.energy_audit(run_of(SCENES["A"], 0.5, method=fl.RK4(h))).error for h in (1e-3, 1e-4))
    assert 1e-12 < fine < coarse < 1e-2


def test_what_rounding_takes_is_no_work_of_impacts():
    """A mass that comes to stick loses 1e-31 J by the reset of its velocity."""
    audit = fl.energy_audit(fl.simulate(fl.DenHartog(), 30.0, progress=False), progress=False)
    assert abs(audit.works["impacts"][-1]) < 1e-30
    assert "impacts" not in repr(audit)
    rounding = dict.fromkeys(audit.works, np.full_like(audit.t, 1e-31))
    at_rest = replace(audit, works=rounding)
    assert "no work" in repr(at_rest)
    assert [line.get_label() for line in plot_works(at_rest)] == ["sum"]


def test_samples_do_not_matter():
    t = np.linspace(0.0, 1.0, 37)
    few, many = (fl.energy_audit(run_of(SCENES["B"], 1.0, t_eval=times)) for times in (t, None))
    assert few.t == pytest.approx(t)
    for name, work in few.works.items():
        assert work[-1] == pytest.approx(many.works[name][-1], abs=1e-11)
    assert few.error < 1e-13


def test_impacts_at_one_instant_are_counted_at_one_sample():
    """Between them is a step that the clock does not resolve, whose samples round to the second impact."""
    run = fl.simulate(fl.NewtonsCradle(e=0.9), 10.0, progress=False)
    audit = fl.energy_audit(run, progress=False)
    assert audit.works["impacts"][-1] < -1e-3
    assert audit.error < 1e-12


@dataclass(frozen=True, repr=False)
class StiffenedBySquare(fl.ContactLaw):
    """From a penetration of sqrt(c/b) on a square is added, whose border is not linear in the penetration."""

    k2: float = 100.0
    b: float = 4e3
    c: float = 0.5

    def force(self, penetration):
        return self.k2 * penetration + fl.functions.maximum(self.b * penetration**2 - self.c, 0.0)


def test_a_structure_on_a_contact_law_with_a_square_in_its_border_keeps_its_energy():
    pads = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], StiffenedBySquare(), fl.Coulomb(0.2, 0.2), v=0.3)
    structure = fl.Structure(np.eye(2), np.diag([1.0, 2.0]), contacts=pads)
    run = fl.simulate(structure, 3.0, x0=[0.0, -0.1, 0.0, 1.0], progress=False)
    assert len(run.events) > 5
    assert fl.energy_audit(run, progress=False).error < 1e-13
