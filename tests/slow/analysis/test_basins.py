"""Basins of attraction against published shares and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.basins import tasks as module
from frictionlab.analysis.basins.basins import basins_from_results
from tests.helpers.automata import V, X, automaton
from tests.helpers.known_motions import bistable

SHARES = {1.25: 0.08020, 1.5: 0.30713, 1.7: 0.49411}
QUIET = {"transient": 40.0, "window": 20.0, "progress": False}


def on_the_law(belt):
    """The third state of the bistable oscillator is exp(-2 |v_r|)."""
    return lambda z: [z[0], z[1], np.exp(-2 * abs(z[1] - belt))]


def wells():
    """x' = x - x^3, v' = -v: what starts right of zero goes to 1, what starts left of it to -1."""
    return automaton(fl.Mode("only", (X - X**3, -V)), coordinates=0)


def rings():
    """r' = r (1 - r^2) (r^2 - 1/4) in a turning plane: within 1/2 to 0, else to the circle."""
    square = X**2 + V**2
    grow = (1 - square) * (square - sp.Rational(1, 4))
    return automaton(fl.Mode("only", (X * grow - V, V * grow + X)), coordinates=0)


@pytest.mark.parametrize("belt", SHARES)
def test_the_bistable_oscillators_share_is_the_published_one(belt):
    options = {"samples": 10_000, "x0": on_the_law(belt), "transient": 1000.0, "progress": False}
    found = fl.basin_stability(bistable(belt), {"x": (-2.0, 2.0), "v": (0.0, 2.0)}, **options)
    share = SHARES[belt]
    error = np.sqrt(share * (1 - share) / 10_000)
    assert found.fractions["equilibrium"] == pytest.approx(share, abs=3 * error)
    assert found.errors["equilibrium"] == pytest.approx(error, rel=0.03)
    assert sorted(a.kind for a in found.attractors) == ["equilibrium", "periodic"]
    assert sum(found.fractions.values()) == pytest.approx(1.0)


def test_early_looks_take_no_motion_for_another():
    """Against each motion by itself, all the way: at rest it is where x = (1 + exp(-2 v_d))/2."""
    belt, options = 1.5, {"samples": 150, "transient": 1000.0, "progress": False}
    found = fl.basin_stability(
        bistable(belt), {"x": (-2.0, 2.0), "v": (0.0, 2.0)}, x0=on_the_law(belt), **options
    )
    starts = [on_the_law(belt)([*point, 0.0]) for point in found.points]
    ends = [fl.solve(bistable(belt), 1000.0, x0=start, progress=False).final_state for start in starts]
    away = np.abs(np.array(ends) - [(1 + np.exp(-2 * belt)) / 2, 0.0, np.exp(-2 * belt)]).max(axis=1)
    assert ((away < 1e-6) | (away > 0.5)).all()
    assert np.array_equal(
        np.take([a.kind == "equilibrium" for a in found.attractors], found.labels), away < 0.5
    )


@pytest.mark.parametrize(("rtol", "kind"), [(1e-2, "equilibrium"), (1e-3, "not settled yet")])
def test_a_decaying_motion_is_at_its_attractor_within_the_tolerance_asked_for(rtol, kind):
    """Of q'' = -q - q'/10 there is exp(-5.75) = 0.0032 left where the last quarter begins, at 115 s."""
    grid = {"x": ("q0", [0.5, 1.0]), "y": ("q0'", [0.0, 0.5])}
    oscillator = fl.Structure([[1.0]], [[1.0]], [[0.1]])
    found = fl.basins(oscillator, **grid, transient=100.0, window=20.0, rtol=rtol, progress=False)
    assert [one.kind for one in found.attractors] == [kind]


def test_the_size_of_the_groups_makes_no_difference(monkeypatch):
    grid, labels = np.linspace(-1.2, 1.2, 9), []
    for size in (7, 30, 250):
        monkeypatch.setattr(module, "MIN_GROUP_SIZE", size)
        found = fl.basins(rings(), ("x", grid), ("v", grid), **QUIET)
        labels.append(found.labels)
        assert found.specification["group"] == size
    assert np.array_equal(labels[0], labels[1])
    assert np.array_equal(labels[0], labels[2])


def test_two_wells_are_parted_where_they_should_be():
    x, v = np.linspace(-1.5, 1.5, 8), np.linspace(-1.0, 1.0, 5)
    found = fl.basins(wells(), ("x", x), ("v", v), **QUIET)
    assert found.labels.shape == (5, 8)
    right = [a.state[0] > 0 for a in found.attractors]
    assert [right[i] for i in found.labels[0]] == (x > 0).tolist()
    assert (found.labels == found.labels[0]).all()
    assert sorted(found.fractions) == ["equilibrium", "equilibrium (2)"]
    assert set(found.fractions.values()) == {0.5}
    ends = sorted(a.state.round(9).tolist() for a in found.attractors)
    assert ends == [[-1.0, 0.0], [1.0, 0.0]]


def test_an_unstable_circle_bounds_the_basin_of_rest():
    grid = np.linspace(-1.2, 1.2, 13)
    found = fl.basins(rings(), ("x", grid), ("v", grid), **QUIET)
    inside = np.hypot(*np.meshgrid(grid, grid)) < 0.5
    resting = [a.kind == "equilibrium" for a in found.attractors]
    assert np.array_equal(np.take(resting, found.labels), inside)
    (circle,) = [a for a in found.attractors if a.kind == "periodic"]
    assert circle.name == "period 6.283 s"
    assert circle.period == pytest.approx(2 * np.pi, abs=1e-9)
    assert [*circle.low, *circle.high] == pytest.approx([-1, -1, 1, 1], abs=1e-6)
    assert np.hypot(*circle.path.T) == pytest.approx(1.0, abs=1e-9)


def test_an_attractor_that_no_probe_found_is_reported(monkeypatch):
    monkeypatch.setattr(module, "probe_indices", lambda count: [0])
    found = fl.basins(wells(), ("x", [-1.0, -0.5, 0.5, 2.0]), ("v", [0.0, 1.0]), **QUIET)
    assert found.labels.tolist() == [[0, 0, 1, 1]] * 2
    assert [a.state[0] for a in found.attractors] == pytest.approx([-1.0, 1.0])


def test_an_attractor_of_a_probe_to_which_no_state_leads_is_not_listed():
    left, right = (fl.basins(wells(), ("x", x), ("v", [0.0, 1.0]), **QUIET) for x in ([-1, -0.5], [0.5, 2.0]))
    labels = {left.specification["probes"]: {"labels": [1] * 4, "found": []}}
    found = basins_from_results(left.specification, left.results | {0: right.results[0]} | labels)
    assert found.fractions == {"equilibrium": 1.0}
    assert (found.labels == 0).all()
    assert found.attractors[0].state[0] == pytest.approx(-1.0)


def test_what_friction_holds_against_a_force_is_one_attractor_at_all_times():
    """At N = 1.5 a mass within 0.5 of where the spring is slack never moves; its phase goes on."""
    found = fl.basins(
        fl.DenHartog(N=1.5),
        ("x", [0.1, 0.2]),
        ("phase", [0.0, 1.0, 4.0]),
        transient=20.0,
        window=20.0,
        progress=False,
    )
    assert [a.kind for a in found.attractors] == ["equilibrium"] * 2
    assert (found.labels == found.labels[:, :1]).all() or (found.labels == found.labels[:1]).all()
    for attractor, x in zip(found.attractors, (0.1, 0.2)):
        assert attractor.low[:2] == pytest.approx([x, 0.0], abs=1e-12)
        assert attractor.high[2] - attractor.low[2] == pytest.approx(2 * np.pi, abs=0.01)


def test_the_sliders_two_motions():
    """Near the equilibrium and far from it, as Fig. 7 has it at mu_k = 1.4."""
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
    speeds = ("x1'", [0.0, 1.0]), ("y1'", [0.0, 1.0])
    found = fl.basins(model, *speeds, "near", transient=300.0, window=20.0, progress=False)
    kinds = np.take([a.kind for a in found.attractors], found.labels)
    assert kinds.tolist() == [["equilibrium", "periodic"], ["periodic", "periodic"]]
    for i, name in ((0, "rest"), (1, "near")):
        alone = fl.steady_state(model, name, transient=300.0, window=20.0, progress=False)
        (attractor,) = [a for a in found.attractors if a.kind == alone.kind]
        assert alone.kind == ("periodic", "equilibrium")[i]
        if alone.kind == "periodic":
            assert attractor.period == pytest.approx(alone.period, rel=1e-6)


def test_what_does_not_settle_or_ends_early_is_said():
    drift = automaton(fl.Mode("only", (sp.S.One, X)), coordinates=0)  # what grows makes a difference
    found = fl.basins(drift, ("x", [0.0, 1.0]), ("v", [0.0]), **QUIET)
    assert found.fractions == {"not settled yet": 1.0}
    blast = automaton(fl.Mode("only", (X**2, -V)), coordinates=0)
    found = fl.basins(blast, ("x", [-1.0, 1.0]), ("v", [0.0]), transient=2000.0, window=20.0, progress=False)
    assert found.fractions["ended early"] == 0.5


def test_neither_workers_nor_being_cut_off_make_a_difference(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MIN_GROUP_SIZE", 20)
    path, grid = tmp_path / "basins.jsonl", np.linspace(-1.2, 1.2, 9)
    arguments = rings(), ("x", grid), ("v", grid)
    whole = fl.basins(*arguments, workers=2, **QUIET).save(tmp_path / "whole").read_bytes()
    fl.basins(*arguments, workers=1, resume=path, **QUIET)
    assert path.read_bytes() == whole
    for lines in (3, module.PROBE_COUNT + 3):
        path.write_bytes(b"".join(whole.splitlines(keepends=True)[:lines]))
        part = fl.load_basins(path)
        assert (part.labels < 0).any()
        fl.basins(*arguments, resume=path, **QUIET)
        assert path.read_bytes() == whole
    loaded, found = fl.load_basins(path), fl.basins(*arguments, **QUIET)
    assert np.array_equal(loaded.labels, found.labels)
    assert repr(loaded) == repr(found)
    with pytest.raises(ValueError, match="differs in x"):
        fl.basins(rings(), ("x", grid[1:]), ("v", grid), resume=path, **QUIET)


def test_random_states_are_saved_and_loaded(tmp_path):
    options = {"samples": 50, "rng": 3, **QUIET}
    found = fl.basin_stability(wells(), {"x": (-1.0, 3.0)}, **options)
    loaded = fl.load_basins(found.save(tmp_path / "stability"))
    assert np.array_equal(loaded.points, found.points)
    assert np.array_equal(loaded.labels, found.labels)
    right = [a.state[0] > 0 for a in found.attractors]
    assert np.array_equal(np.take(right, found.labels), found.points[:, 0] > 0)
    assert "+-" in repr(loaded)
    older = {name: value for name, value in found.specification.items() if name != "cyclic"}
    assert fl.load_basins(replace(found, specification=older).save(tmp_path / "older")).cyclic == ()
    with pytest.raises(ValueError, match="must be a file of basins"):
        fl.load_basins(
            fl.bifurcation(fl.SliderOnBelt(), "mu_k", [0.2], transient=0.1, window=0.1, progress=False).save(
                tmp_path / "other"
            )
        )
