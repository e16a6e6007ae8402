"""Files of runs: damaged ones, those of other models, and a disk that is full."""

import json

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl

X, V, K, N = sp.symbols("x v k n")
FAULTS = np.random.default_rng(5)


def oscillator(stiffness=4.0, shift=0, names=("left", "right")):
    """Two modes, the signs of x."""
    modes = [
        fl.Mode(names[0], (V, -K * X + shift), (fl.Event("left end", -X, (names[1],)),)),
        fl.Mode(names[1], (V, -K * X), (fl.Event("right end", X, (names[0],)),)),
    ]
    return fl.HybridAutomaton((X, V), tuple(modes), {K: stiffness}, 1)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    run = fl.solve(oscillator(), 5.0, x0=[-1.0, 0.0], sections={"top": V})
    return run, run.save(tmp_path_factory.mktemp("run") / "run")


def changed(path, target, **changes):
    """The file with other arrays, or other entries of its description."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    about = json.loads(str(arrays.pop("about")))
    for name, change in changes.items():
        if name in arrays:
            arrays[name] = change(arrays[name])
        else:
            about[name] = change(about[name])
    np.savez_compressed(target, about=np.array(json.dumps(about)), **arrays)
    return target


def test_the_same_automaton_gives_the_same_run(saved):
    run, path = saved
    again = fl.load(path, model=oscillator())
    t = np.linspace(0.0, 5.0, 41)
    np.testing.assert_array_equal(again(t), run(t))
    assert again.events.source.tolist() == run.events.source.tolist()
    assert again.problem.x0.tolist() == [-1.0, 0.0]


@pytest.mark.parametrize(
    ("other", "word"),
    [
        (oscillator(stiffness=4.000001), r"parameters \{'k': 4.0\}, got \{'k': 4.000001\}"),
        (oscillator(names=("right", "left")), "mode names"),
        (oscillator(shift=sp.Float(1e-3)), "other equations: at its first step in mode 'left'"),
        (fl.MassOnBelt(), "states"),
    ],
)
def test_another_automaton_is_refused(saved, other, word):
    _, path = saved
    with pytest.raises(ValueError, match=word) as caught:
        fl.load(path, model=other)
    assert str(path) in str(caught.value)
    assert "load(path, model=...)" in str(caught.value)


def test_arrays_of_someone_else_are_no_run(tmp_path):
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    np.save(tmp_path / "single.npy", np.arange(3))
    for name in ("other.npz", "single.npy"):
        with pytest.raises(ValueError, match="no saved run"):
            fl.load(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        fl.load(tmp_path / "missing.npz")


# Kernels check no indices.
CRAFTED = {
    "step_modes": lambda a: a + 1_000_000,
    "step_states": lambda a: a[:-1],
    "step_times": lambda a: a[:, :1],
    "event_codes": lambda a: a - 5,
    "event_states": lambda a: a[..., :1],
    "point_states": lambda a: a[:, :0],
    "state": lambda a: a[:1],
    "mode": lambda mode: 77,
    "event_times": lambda a: a.astype(complex),
}


@pytest.mark.parametrize("name", CRAFTED)
def test_arrays_that_cannot_be_are_refused(saved, tmp_path, name):
    _, path = saved
    crafted = changed(path, tmp_path / "crafted.npz", **{name: CRAFTED[name]})
    with pytest.raises(ValueError, match="is damaged") as caught:
        fl.load(crafted, model=oscillator())
    assert str(crafted) in str(caught.value)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("name", "change", "word"),
    [
        ("nodes", lambda nodes: [*nodes[:-1], ["system", 0]], "the operation 'system'"),
        ("nodes", lambda nodes: nodes[:-1], "is damaged"),
        ("states", lambda states: states[:1], "coordinates must leave room"),
        ("parameters", lambda parameters: [], "neither a state nor a parameter"),
        ("parameters", lambda parameters: [[parameters[0][0], 5.0]], "a run with the parameters"),
    ],
)
def test_an_automaton_that_cannot_be_is_refused(saved, tmp_path, name, change, word):
    _, path = saved
    crafted = changed(
        path, tmp_path / "crafted.npz", automaton=lambda data: {**data, name: change(data[name])}
    )
    with pytest.raises(ValueError, match=word) as caught:
        fl.load(crafted)
    assert str(crafted) in str(caught.value)


def faults(whole):
    """Truncated at 20 places, 100 bits flipped, one each, and emptied."""
    for cut in np.linspace(0, len(whole) - 1, 20).astype(int):
        yield whole[:cut]
    for place, bit in zip(FAULTS.integers(0, len(whole), 100), FAULTS.integers(0, 8, 100)):
        flipped = bytearray(whole)
        flipped[place] ^= 1 << bit
        yield bytes(flipped)


def refusal(path):
    """The error that loading a file ends with; "" where it ends well."""
    try:
        fl.load(path, model=oscillator())
    except ValueError as error:
        return str(error)
    return ""


def test_a_damaged_file_is_refused_or_gives_the_same_run(saved, tmp_path):
    """What the archive does not use, such as times of its members, may change without harm."""
    run, path = saved
    damaged, refused = tmp_path / "damaged.npz", 0
    for content in faults(path.read_bytes()):
        damaged.write_bytes(content)
        message = refusal(damaged)
        if message:
            refused += 1
            assert str(damaged) in message
        else:
            np.testing.assert_array_equal(fl.load(damaged, model=oscillator()).states, run.states)
    assert refused > 90


def test_a_damaged_head_of_an_array_is_refused(saved, tmp_path):
    """Numpy reads it as text of Python, before the checksum of the archive is compared."""
    _, path = saved
    damaged = tmp_path / "damaged.npz"
    with np.load(path) as file:
        np.savez(damaged, **{name: file[name] for name in file.files})
    content = damaged.read_bytes()
    assert b": False" in content
    damaged.write_bytes(content.replace(b": False", b": ((((("))
    with pytest.raises(ValueError, match="is no saved run") as caught:
        fl.load(damaged, model=oscillator())
    assert str(damaged) in str(caught.value)


def test_a_full_disk_leaves_the_file_that_was_there(saved, tmp_path, monkeypatch):
    run, path = saved
    target = tmp_path / "run.npz"
    target.write_bytes(path.read_bytes())

    def full(stream, **arrays):
        stream.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="No space left"):
        run.save(target)
    assert target.read_bytes() == path.read_bytes()
    assert [file.name for file in tmp_path.iterdir()] == ["run.npz"]
