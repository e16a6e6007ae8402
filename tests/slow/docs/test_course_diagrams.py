"""What the course keeps of its dense diagrams is what its file `diagrams.py` computes: some points of each,
computed anew."""

import sys
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl

pytestmark = pytest.mark.slow

TUTORIALS = Path(__file__).parents[3] / "tutorials"
DIGITS = 1e-8  # of the numbers in the files


@pytest.fixture(scope="module")
def diagrams():
    """The module beside the notebooks, which is no package."""
    sys.path.insert(0, str(TUTORIALS))
    try:
        import diagrams

        yield diagrams
    finally:
        sys.path.remove(str(TUTORIALS))


def of_kind(diagrams, function):
    return {name: call for name, call in diagrams.DIAGRAMS.items() if call.func is function}


def test_every_diagram_is_kept_and_every_file_has_its_command(diagrams):
    names = [*diagrams.DIAGRAMS, diagrams.PUSHES]
    assert sorted(diagrams.FOLDER.iterdir()) == sorted(map(diagrams.kept, names))
    assert sum(path.stat().st_size for path in diagrams.FOLDER.iterdir()) < 2e6


def test_values_of_the_bifurcation_diagrams(diagrams):
    calls = of_kind(diagrams, fl.bifurcation)
    assert len(calls) == 7
    for name, call in calls.items():
        model, parameter, values, *start = call.args
        kept = fl.load_bifurcation(diagrams.kept(name))
        assert len(kept.values) == 300
        assert np.array_equal(kept.values, values)
        some = [20, 140, 290]
        found = fl.bifurcation(model, parameter, values[some], *start, **call.keywords, progress=False)
        again = "python tutorials/diagrams.py"  # after a change of what describes a model
        assert kept.specification | {"values": found.specification["values"]} == found.specification, again
        assert kept.model == found.model
        for place, i in enumerate(some):
            assert found.kinds[place] == kept.kinds[i], f"{name}, {values[i]}"
            assert found.onsets[place] == kept.onsets[i]
            # Intensities at rest are what is left of the transient.
            assert np.isclose(found.intensities[place], kept.intensities[i], rtol=DIGITS, atol=1e-12)


def test_initial_states_of_the_basins(diagrams):
    calls = of_kind(diagrams, fl.basins)
    assert len(calls) == 2
    for name, call in calls.items():
        options = dict(call.keywords)
        (x, xs), (y, ys) = options.pop("x"), options.pop("y")
        kept = fl.load_basins(diagrams.kept(name))
        assert kept.labels.shape == (100, 100)
        some = [0, 33, 49, 66, 99]
        found = fl.basins(*call.args, (x, xs[some]), (y, ys[some]), **options, progress=False)
        assert kept.specification["model"] == found.specification["model"]
        kinds = [
            np.take([attractor.kind for attractor in one.attractors], one.labels) for one in (found, kept)
        ]
        assert np.array_equal(kinds[0], kinds[1][np.ix_(some, some)])
        assert len({*kinds[0].flat}) == 2


def test_some_pushes(diagrams):
    kept = np.load(diagrams.kept(diagrams.PUSHES))
    assert kept["sticks"].shape == (100, 100)
    for i in (0, 40, 80):
        some = [0, 30, 60, 99]
        assert diagrams.push_fates(kept["mu_k"][i], kept["percent"][some]) == kept["sticks"][i, some].tolist()
