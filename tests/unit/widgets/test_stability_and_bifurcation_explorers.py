"""The explorers of stability and of bifurcations show what the analyses give."""

import asyncio

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.stability.boundaries.stability_changes import curve_and_gaps
from tests.helpers.explorers import columns, curve, said

FLAT = fl.SliderOnBelt().without("geometry")


def watched(explorer):
    """The explorer, shown in a browser."""
    explorer.widget.shown = True
    return explorer


@pytest.fixture(scope="module")
def stability():
    return fl.explore_stability()


@pytest.mark.slow
def test_the_critical_curve_is_that_of_the_analysis(stability):
    at, values = curve(stability, "critical", "critical")
    known = np.flatnonzero(np.isfinite(values))[::7]
    assert len(known) > 2
    for i in known:
        model = fl.SliderOnBelt(F=float(at[i]))
        assert values[i] == pytest.approx(fl.critical_value(model, "mu_k", (0, 3)), rel=1e-9)


def test_the_point_moves_and_changes_where_it_passes_the_curve(stability):
    critical = fl.critical_value(fl.SliderOnBelt(), "mu_k", (0, 3))
    for mu_k, stable in ((critical - 0.01, True), (critical + 0.01, False)):
        stability.controls["mu_k"].value = mu_k
        names = ("stable", "unstable")[:: 1 if stable else -1]
        (x, y), (elsewhere, _) = (curve(stability, "critical", f"here, {name}") for name in names)
        assert (x.tolist(), y.tolist()) == ([200.0], [mu_k])
        assert len(elsewhere) == 0
        assert stability.result.eigenvalues.stable is stable
    rates = fl.eigenvalues(stability.model).growth_rates
    grows = said(stability.widget, "eigenvaluePanel(result).curves.at(-1).x")
    assert grows == pytest.approx([rates.max()])


@pytest.mark.slow
def test_moving_the_point_computes_no_curve_anew(stability, monkeypatch):
    computed = []

    def counted(model, *args, **options):
        computed.append(model)
        return curve_and_gaps(model, *args, **options)

    monkeypatch.setattr("frictionlab.widgets.panels.critical_value.curve_and_gaps", counted)
    stability.controls["mu_k"].value = 0.7
    stability.controls["F"].value = 450.0
    assert not computed
    stability.controls["k5"].value = 1.5e4
    assert [model.k5 for model in computed] == [1.5e4]
    assert "run" not in vars(stability.result)


@pytest.mark.slow
def test_in_an_event_loop_the_critical_curve_becomes_finer():
    async def browser():
        explorer = watched(fl.explore_stability())
        seen = []
        while explorer.progress:
            seen.append(np.array(curve(explorer, "critical", "critical")))
            await asyncio.sleep(0.02)
        return explorer, [*seen, np.array(curve(explorer, "critical", "critical"))]

    explorer, seen = asyncio.run(browser())
    assert explorer.error is None
    first, last = seen[0], seen[-1]
    assert (first.shape[1], last.shape[1]) == (21, 87)
    assert np.array_equal(first, last[:, 3::4], equal_nan=True)
    steps = np.diff(last[0])
    assert steps == pytest.approx(steps[0])
    alone = fl.critical_value(fl.SliderOnBelt(F=float(last[0, 41])), "mu_k", (0, 3))
    assert last[1, 41] == pytest.approx(alone, rel=1e-9)


def test_a_click_sets_both_parameters(stability):
    assert stability.widget.picture["drawings"]["critical"]["pick"] == ("F", "mu_k")


def test_two_different_parameters_are_needed():
    with pytest.raises(ValueError, match="over must be another parameter than 'F'"):
        fl.explore_stability(parameter="F", over="F")


LONGEST = 1e4  # s: longer than any of these motions takes to settle


@pytest.fixture(scope="module")
def diagram():
    explorer = fl.explore_bifurcation(FLAT.replace(mu_k=0.5, mu_s=4.0))
    explorer.controls["transient"].value = 5.0
    return explorer


@pytest.fixture(scope="module")
def block():
    """The diagram of a mass on a belt, which takes less than the slider's."""
    explorer = fl.explore_bifurcation(fl.MassOnBelt(c=0.05, mu_s=4.0))
    explorer.controls["transient"].value = 50.0
    return explorer


def waiting(panel):
    """Values whose motions have not settled."""
    return {value for value, found in panel.steady_states.items() if found.kind == "not settled yet"}


def shown(explorer):
    curves = explorer.drawings["bifurcation"].curves
    return np.unique(np.concatenate([np.asarray(c.x) for label, c in curves.items() if label != "_here"]))


@pytest.mark.slow
def test_a_narrow_range_is_computed_more_finely_and_nothing_twice(diagram):
    panel = diagram.panels["bifurcation"]
    diagram.controls["range"].value = (0.0, 1.2)
    coarse = dict(panel.steady_states)
    assert len(shown(diagram)) >= 24
    diagram.controls["range"].value = (0.3, 0.6)
    fine = shown(diagram)
    assert len(fine) >= 24
    assert (fine.min(), fine.max()) == (0.3, 0.6)
    assert all(panel.steady_states[value] is coarse[value] for value in coarse)
    assert diagram.drawings["bifurcation"].xlim == (0.3, 0.6)


@pytest.mark.slow
def test_the_points_are_those_of_the_analysis(diagram):
    diagram.controls["range"].value = (0.3, 0.6)
    sweep = diagram.panels["bifurcation"].sweep
    found, method = sweep.steady_states, sweep.options.method
    assert (method.tol, method.chatter) == (1e-10, diagram.result.settings.method.chatter)
    model = FLAT.replace(mu_s=4.0)
    options = {"transient": 5.0, "window": 10.0, "t_max": LONGEST, "method": method, "progress": False}
    expected = fl.bifurcation(model, "mu_k", [0.6], **options)
    kind, states, _ = found[0.6]
    assert kind == expected.kinds[0]
    assert np.array_equal(states, expected.sections[0])


@pytest.mark.slow
def test_the_slider_of_the_parameter_selects_a_value_and_computes_no_diagram(block):
    panel = block.panels["bifurcation"]
    before = dict(panel.steady_states)
    block.controls["mu_k"].value = 0.45
    assert panel.steady_states == before
    assert block.drawings["bifurcation"].curves["_here"].x == [0.45, 0.45]
    assert columns(block.widget)["x"][-1] == block.run.final_state[0]
    assert block.model.mu_k == 0.45


@pytest.mark.slow
def test_another_parameter_means_another_diagram(diagram):
    panel = diagram.panels["bifurcation"]
    assert diagram.widget.scene["settles"] == "mu_k"  # only this one is followed while it moves
    before = panel.sweep
    diagram.controls["F"].value = 250.0
    assert panel.sweep is not before
    assert len(panel.steady_states) == 24


@pytest.fixture(scope="module")
def filled():
    """An explorer that was filled in an event loop, and meanwhile: values, how many, progress."""

    async def browser():
        explorer, seen = watched(fl.explore_bifurcation(FLAT.replace(mu_k=0.5))), []
        panel = explorer.panels["bifurcation"]
        for value in (4.0, 4.5, 5.0):
            explorer.controls["transient"].value = value  # another diagram, before the first is done
        while explorer.progress:
            done = len(panel.steady_states) - len(waiting(panel))
            seen.append((dict(panel.steady_states), done, explorer.widget.picture["progress"]))
            await asyncio.sleep(0.02)
        return explorer, seen

    return asyncio.run(browser())


@pytest.mark.slow
def test_in_an_event_loop_the_diagram_fills_while_newer_values_are_heard(filled):
    explorer, seen = filled
    assert 0 < len(seen[0][0]) < 300
    assert all(progress == [done, 300] for _, done, progress in seen)
    panel = explorer.panels["bifurcation"]
    assert (len(panel.steady_states), explorer.widget.picture["progress"]) == (300, None)
    assert explorer.drawings["bifurcation"].note == "300 values"
    assert explorer.error is None
    assert panel.sweep.options.transient == 5.0
    assert not panel.sweep.has_previews  # they would take as long


@pytest.mark.slow
def test_a_coarse_diagram_comes_first_and_is_refined_evenly(filled):
    explorer, seen = filled
    every = np.linspace(*explorer.controls["range"].value, 300)
    last = explorer.panels["bifurcation"].steady_states
    assert sorted(last) == every.tolist()
    order = np.searchsorted(every, list(last)).tolist()
    assert sorted(order[:24]) == [*range(0, 300, 13)]
    for i in range(24, 300, 23):
        assert len({place % 13 for place in order[i : i + 23]}) == 1  # one in each interval
    for found, *_ in seen:
        kept = list(found)
        assert kept == list(last)[: len(kept)]  # nothing is computed twice


@pytest.mark.slow
def test_a_preview_of_a_short_transient_comes_first_and_is_said_to_be_one():
    async def browser():
        explorer, seen = watched(fl.explore_bifurcation(FLAT.replace(mu_k=0.5))), []
        sweep = explorer.panels["bifurcation"].sweep
        while len(sweep.steady_states) < 12:
            await asyncio.sleep(0.02)
            note = explorer.drawings["bifurcation"].note
            seen.append((len(sweep.known), len(sweep.steady_states), note, len(shown(explorer))))
        explorer.close()
        return sweep, seen

    sweep, seen = asyncio.run(browser())
    at_first = [known for known, found, *_ in seen if not found]
    assert at_first == sorted(at_first)
    assert at_first[-1] == 24
    for known, found, note, drawn in seen:
        assert note.startswith(f"{known} of 300 values")
        assert note.endswith(f"{known - found} of a short transient")
        assert drawn == known
    assert (sweep.options.transient, sweep.options.window) == (100.0, 10.0)
    options = {"transient": 10.0, "window": 10.0, "method": sweep.options.method, "progress": False}
    value = max(value for value, found in sweep.known.items() if not found.windows)
    alone = fl.bifurcation(sweep.model, "mu_k", [value], **options)
    kind, states, _ = sweep.known[value]
    assert kind == alone.kinds[0]
    assert np.array_equal(states, alone.sections[0])


@pytest.mark.slow
def test_what_a_slider_changes_is_shown_before_the_diagram_goes_on(monkeypatch):
    monkeypatch.setattr("frictionlab.widgets.explorer.PAUSE_AFTER_CHANGE", 0.5)

    async def browser():
        explorer = watched(fl.explore_bifurcation(FLAT.replace(mu_k=0.5)))
        explorer.controls["transient"].value = 5.0
        panel, counts = explorer.panels["bifurcation"], [0]
        drawn = explorer.widget.picture["samples"]
        for value in (0.51, 0.52, 0.53):
            explorer.controls["mu_k"].value = value
            counts.append(len(panel.steady_states))
            assert explorer.widget.picture["samples"] != drawn
            await asyncio.sleep(0.05)
        assert "of 300 values" in explorer.drawings["bifurcation"].note
        while len(panel.steady_states) == counts[-1]:
            await asyncio.sleep(0.05)
        explorer.close()
        return counts

    counts = asyncio.run(browser())
    assert 0 < counts[1] == counts[2] == counts[3] < 300


@pytest.mark.slow
def test_what_nobody_looks_at_waits():
    async def browser():
        explorer, counts = fl.explore_bifurcation(FLAT.replace(mu_k=0.5)), []
        for shown_now in (False, True):
            explorer.widget.shown = shown_now
            updates = explorer.updates
            await asyncio.sleep(0.5)
            counts.append(explorer.updates - updates)
        explorer.close()
        return counts

    unseen, seen = asyncio.run(browser())
    assert unseen == 0 < seen


@pytest.mark.slow
def test_an_explorer_that_is_closed_computes_no_more():
    async def browser():
        explorer = watched(fl.explore_bifurcation(FLAT.replace(mu_k=0.5)))
        updates = explorer.updates
        explorer.close()
        await asyncio.sleep(0.1)
        return explorer.updates - updates

    assert asyncio.run(browser()) == 0


FULL = fl.SliderOnBelt(mu_k=0.5, impact=fl.PlasticImpact("full"))


@pytest.mark.slow
def test_motions_that_have_not_settled_are_marked_and_go_on_until_they_have():
    async def browser():
        explorer = watched(fl.explore_bifurcation(FULL))
        panel, notes = explorer.panels["bifurcation"], []
        explorer.controls["range"].value = (0.5, 1.0)
        explorer.controls["transient"].value = 40.0
        while explorer.progress:
            await asyncio.sleep(0.02)
            note = explorer.drawings["bifurcation"].note
            notes.append((len(panel.steady_states), note, waiting(panel)))
        return explorer, notes

    explorer, notes = asyncio.run(browser())
    filled = [(note, left) for count, note, left in notes if count == 300]
    assert filled[0][0].splitlines()[0] == f"300 values, {len(filled[0][1])} not settled yet"
    assert len(filled[0][1]) > 12
    assert [len(left) for _, left in filled] == sorted((len(left) for _, left in filled), reverse=True)
    assert filled[-1] == ("300 values", set())
    panel, value = explorer.panels["bifurcation"], max(filled[0][1])
    options = {"transient": 40.0, "window": 10.0, "t_max": LONGEST}
    options["method"] = panel.sweep.options.method
    alone = fl.bifurcation(FULL, "mu_k", [value], progress=False, **options)
    kind, states, _ = panel.steady_states[value]
    assert kind == alone.kinds[0] == "periodic"
    assert np.array_equal(states, alone.sections[0])


@pytest.mark.slow
def test_what_never_settles_is_left_as_it_is_and_no_picture_waits_for_it(monkeypatch):
    monkeypatch.setattr("frictionlab.widgets.panels.bifurcation.EXTENSIONS", (1, 2))

    async def browser():
        explorer = watched(fl.explore_bifurcation(FULL))
        explorer.controls["range"].value = (0.5, 1.0)
        explorer.controls["transient"].value = 5.0
        panel, before = explorer.panels["bifurcation"], None
        while explorer.progress:
            await asyncio.sleep(0.02)
            if before is None and len(panel.steady_states) == 300:
                before = dict(panel.steady_states)
                explorer.controls["mu_k"].value = 0.75  # is shown before anything goes on
                shown = explorer.model.mu_k, dict(panel.steady_states)
        return explorer, before, shown

    explorer, before, (mu_k, found) = asyncio.run(browser())
    assert mu_k == 0.75
    assert all(found[value] is before[value] for value in before)
    assert explorer.error is None
    assert "not settled yet" in explorer.drawings["bifurcation"].note


@pytest.mark.slow
def test_a_model_without_the_usual_parameter_has_a_bifurcation_explorer():
    model = fl.MassOnBeam()
    explorer = fl.explore_bifurcation(model)
    assert explorer.widget.scene["settles"] == next(iter(model.parameters))
    explorer.close()
    plane = fl.explore_stability(fl.PoppStelter())
    assert plane.error is None
    plane.close()
