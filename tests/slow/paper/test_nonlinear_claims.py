"""The claims on steady states: converged numbers, and how verdicts come about."""

import pytest

import frictionlab as fl
from frictionlab.paper.checks import nonsmooth
from frictionlab.paper.results import (
    ClaimCheck,
    Finding,
    Verdict,
    compare,
)
from frictionlab.paper.scenes import Setting, steady_state_of

USUAL = fl.SliderOnBelt()
FULL = Setting(impact="full gap rate", progress=False)


def settled(model, **options):
    return fl.steady_state(model, **{"transient": 100.0, "window": 20.0, "progress": False} | options)


@pytest.mark.parametrize("mu_k", [0.2, 0.3])
def test_without_gn_and_from_rest_little_friction_leads_to_the_equilibrium(mu_k):
    model = USUAL.replace(mu_k=mu_k).without("geometry")
    assert settled(model, transient=180.0).kind == "equilibrium"


@pytest.mark.parametrize(
    ("mu_k", "intensity", "frequency"),
    [(0.38, None, None), (1.0, None, None), (1.4, 0.0011702, 11.048), (2.9, 0.0017786, None)],
)
def test_without_gn_more_friction_leads_to_a_cycle(mu_k, intensity, frequency):
    found = settled(USUAL.replace(mu_k=mu_k).without("geometry"))
    assert (found.kind, found.onsets_per_period) == ("periodic", 1)
    if intensity:
        assert found.intensity == pytest.approx(intensity, abs=1.5e-7)
    if frequency:
        assert 1 / found.period == pytest.approx(frequency, abs=5e-4)


@pytest.mark.parametrize(
    ("mu_k", "intensity", "frequency"),
    [(0.4, None, None), (1.4, 0.0012219, 11.05), (2.5, 0.001657, 11.03), (2.9, None, None)],
)
def test_the_full_gap_rate_gives_one_onset_a_period(mu_k, intensity, frequency):
    found = steady_state_of(USUAL.replace(mu_k=mu_k), FULL)
    assert (found.kind, found.onsets_per_period) == ("periodic", 1)
    if intensity:
        assert found.intensity == pytest.approx(intensity, rel=5e-4)
        assert 1 / found.period == pytest.approx(frequency, abs=0.005)


def test_the_full_gap_rate_at_little_friction():
    assert steady_state_of(USUAL.replace(mu_k=0.3), FULL).kind == "equilibrium"


def test_the_impact_as_printed_gives_three_onsets_a_period():
    found = steady_state_of(USUAL.replace(mu_k=1.4), Setting(progress=False))
    assert (found.kind, found.onsets_per_period) == ("periodic", 3)
    assert 1 / found.period == pytest.approx(3.56, abs=0.005)
    assert found.intensity == pytest.approx(0.0138, abs=5e-5)


def test_the_impact_as_printed_at_much_friction():
    assert steady_state_of(USUAL.replace(mu_k=2.5), Setting(progress=False)).kind == "non-periodic"


def test_the_papers_algorithm_gives_the_papers_motion():
    found = steady_state_of(USUAL.replace(mu_k=1.4), Setting(algorithm="paper", progress=False))
    assert found.kind == "periodic"
    assert 1 / found.period == pytest.approx(1.58, abs=0.01)
    spectrum = found.spectrum()
    assert spectrum is not None
    assert spectrum.peaks()[0][0] == pytest.approx(11.07, abs=0.02)
    assert found.intensity == pytest.approx(0.05, rel=0.1)


def test_the_stiff_structure_loses_stability_where_the_paper_says():
    assert nonsmooth.critical_mu_k() == pytest.approx(1.735, abs=5e-4)


def checked(exact, full, paper, *, impacts=True):
    """A claim whose parts hold as said, in each way."""
    ways = {("exact", "paper"): exact, ("exact", "full gap rate"): full, ("paper", "paper"): paper}

    def check(setting):
        held = ways[setting.algorithm, setting.impact]
        return Finding(str(setting), dict(zip(("it is so", "it is thus"), held)))

    return compare("C0", ClaimCheck("nowhere", "so and thus", check, impacts), Setting())


YES, HALF, NO = (True, True), (True, False), (False, False)


@pytest.mark.parametrize(
    ("exact", "full", "paper", "verdict"),
    [
        (YES, NO, NO, Verdict.REPRODUCED),
        (HALF, YES, YES, Verdict.BY_PAPER),
        (NO, NO, YES, Verdict.BY_PAPER),
        (HALF, YES, NO, Verdict.IN_PART),
        (NO, YES, HALF, Verdict.NOT_REPRODUCED),
    ],
)
def test_the_exact_solver_decides(exact, full, paper, verdict):
    assert checked(exact, full, paper).verdict is verdict


def test_c18_compares_cycles(monkeypatch):
    from frictionlab.paper import scenes

    monkeypatch.setattr(scenes, "USUAL_TIMES", scenes.Times(40.0, 10.0))
    monkeypatch.setattr(scenes, "FIXED_STEP_TIMES", scenes.Times(10.0, 5.0))
    row = fl.paper.claims("C18", progress=False)["C18"]
    assert row.verdict is Verdict.REPRODUCED
    assert row.full_gap_rate == ""
    for frequency in ("11.029 Hz", "11.037 Hz", "12.746 Hz"):
        assert frequency in row.computed
