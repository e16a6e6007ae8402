"""Bad values for every public name."""

import inspect
import os
import tracemalloc
from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp
from scipy.stats import uniform

import frictionlab as fl
from frictionlab.components.component import Component
from frictionlab.models import Friction, Mechanics
from frictionlab.validation import abbreviate
from tests.faults.bad_values import SLOW_DOORS, bad_values, doors, try_value

QUIET = {"progress": False}
BELT = fl.MassOnBelt()
SHORT_FORM = ("object", "10**400", "nested", "long text", "long key")
X = sp.Symbol("x", real=True)


def test_every_public_name_that_is_called_has_a_door():
    known = {name.partition(".")[0] for name in doors()}
    for name in fl.__all__:
        public = getattr(fl, name)
        if inspect.isfunction(public) or (isinstance(public, type) and issubclass(public, Component)):
            assert name in known or public in (fl.Model, fl.MechanicalModel), name


@pytest.mark.parametrize("slow", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_no_value_leads_to_a_raw_error(slow, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # files of any name may be written
    bad, values = [], bad_values()
    for name in [name for name in doors() if (name in SLOW_DOORS) == slow]:
        for argument in doors()[name].arguments():
            for value in SHORT_FORM:
                found = try_value(doors()[name], argument, values[value])
                if found.verdict not in ("taken", "refused"):
                    bad.append(f"{name}({argument}={value}) {found.verdict}: {found.about}")
    assert not bad, "\n".join(bad)


@dataclass(frozen=True)
class WithConstructor(fl.MechanicalModel):
    m: float = 1.0
    coordinates = ("q",)


def of_flow(flow):
    return fl.solve(fl.HybridAutomaton((X,), (fl.Mode("on", flow),)), 1.0, x0=[0.0], **QUIET)


def heun(**changes):
    class Heun(fl.OneStepMethod):
        name = "heun"
        tableau = fl.Tableau(**{"stages": ((), (1.0,)), "weights": (1.0, 1.0), "divisor": 2.0} | changes)

    return fl.simulate(BELT, 0.1, method=Heun(step=1e-2), **QUIET)


RUN = fl.simulate(BELT, 2.0, **QUIET)
TOLERANCE = r"simulate takes no 'rtol': tolerances are the method's: write method=fl.Taylor\(tol="
# fmt: off
REFUSED = {
    "a callable as flow": (
        lambda: of_flow((lambda x: x,)), TypeError, "the flow of mode 'on' must be an expr",
    ),
    "rtol": (lambda: fl.simulate(BELT, rtol=1e-6), TypeError, TOLERANCE),
    "t_span": (lambda: fl.simulate(BELT, t_span=(0, 1)), TypeError, "takes no 't_span'.*t_end"),
    "of solve": (
        lambda: fl.solve(BELT.automaton(), 1.0, x0=[0, 0], rtol=1e-6), TypeError, "solve takes no 'rtol'",
    ),
    "a dataclass as model": (WithConstructor, TypeError, "write @fl.model in place of @dataclass"),
    "a map of one axis": (
        lambda: fl.stability_map(BELT, {"k": [1, 2]}), TypeError,
        r"stability_map needs y too: write stability_map\(model, x, y\)",
    ),
    "a run to verify": (lambda: fl.verify(RUN), TypeError, r"verify needs t_end too: write verify\(model"),
    "a map of one mapping": (
        lambda: fl.stability_map(BELT, {"k": [1, 2]}, ("N", [1, 2])), ValueError, "x must be a para",
    ),
    "an index of a run": (lambda: RUN[5], ValueError, r"got 5: write run\['x'\]"),
    "a spectrum of a model": (lambda: fl.amplitude_spectrum(BELT), TypeError, "run must be a Trajectory"),
    "a spectrum from before": (
        lambda: fl.amplitude_spectrum(RUN, start=-1e9), ValueError, "start must be .*at least 0",
    ),
    "a long spectrum": (lambda: fl.amplitude_spectrum(RUN, f_max=1e9), ValueError, "lower f_max"),
    "a sound's suffix": (lambda: fl.listen(RUN).save("a.mp3"), ValueError, r"must end in .wav, got 'a.mp3'"),
    "a run's suffix": (lambda: RUN.save("a.mp3"), ValueError, r"must end in .npz"),
    "a picture's suffix": (lambda: RUN.plot().figure.savefig("a.mp3"), ValueError, r"must end in"),
    "a page's suffix": (lambda: fl.export_page(BELT, "a.mp3"), ValueError, r"must end in .html"),
    "complex states": (lambda: fl.simulate(BELT, 1.0, x0=[1.0, 1j]), ValueError, "x0 must hold numbers"),
    "None as a parameter": (lambda: fl.bifurcation(BELT, None, [1.0]), TypeError, "has no parameter None"),
    "no": (
        lambda: fl.simulate(BELT, 1.0, progress="no"), TypeError, "progress must be True or False, got 'no'",
    ),
    "a tableau's shape": (
        lambda: heun(stages=(0.5, 1.0)), ValueError, "a row of a tableau must be a sequence",
    ),
    "a masked record": (
        lambda: fl.TimeRecord([0.1, 0.2], {"x": np.ma.masked_array([1, 2], [0, 1])}), ValueError, "x",
    ),
    "a slow sound": (lambda: fl.listen(RUN, pitch=1e-9), ValueError, "at most .* samples"),
    "a section's direction": (
        lambda: fl.SteadyStateOptions(section=("x'", 2)), ValueError, "section's direction must be .*got 2",
    ),
    "no section": (
        lambda: fl.SteadyStateOptions(section=5), ValueError, "section must be .*got 5: write \"stick\"",
    ),
    "the start of an orbit": (
        lambda: fl.OrbitPeriod(x0="nearby"), ValueError, "x0 must be one of 'rest', 'near', got 'nearby'",
    ),
    "values of a start": (
        lambda: fl.OrbitAmplitude("x", x0={"x": None}), ValueError, r"x0\['x'\] must be .*, got None: give",
    ),
    "a source": (
        lambda: fl.solve(BELT.automaton(), 1.0, x0=[0, 0], source="MassOnBelt"), TypeError,
        "source must be the model of the automaton, got 'MassOnBelt': leave it out",
    ),
    "a pipe": (lambda: load_pipe(), OSError, "must be a file, it is a pipe"),
    "a number as relative velocity": (
        lambda: fl.explore(Rubbed()), ValueError, "must depend on the velocities, got 0.5",
    ),
}
# fmt: on


def load_pipe():
    os.mkfifo("pipe")
    fl.load("pipe")


@fl.model
class Rubbed(fl.MechanicalModel):
    friction: fl.FrictionLaw = fl.Coulomb()
    coordinates = ("q",)

    def mechanics(self, q, v):
        return Mechanics(kinetic=v.q**2 / 2, contacts=(Friction(0.5, 1.0, self.friction),))


@pytest.mark.parametrize("name", REFUSED)
def test_one_clear_error_first(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, error, message = REFUSED[name]
    with pytest.raises(error, match=message):
        call()
    assert not [path for path in tmp_path.iterdir() if path.is_file()]


@pytest.mark.slow
def test_a_small_file_that_takes_a_large_memory_is_refused_before(tmp_path):
    """Memory is bounded by tracemalloc, which numpy tells of its arrays."""
    np.savez_compressed(
        tmp_path / "bomb.npz", about="{}", step_states=np.zeros((20_000_000, 8), dtype=np.int8)
    )
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"bomb.npz has format None, this version reads"):
            fl.load(tmp_path / "bomb.npz")
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_integral_numbers_are_integers():
    assert type(fl.Taylor(order=12.0).order) is int
    preload = {"F": uniform(150.0, 50.0)}
    found = fl.uncertainty(fl.SliderOnBelt(), fl.GrowthRate(), preload, n=16.0, workers=1.0, **QUIET)
    assert len(found.values) == 16


def test_a_class_in_a_function_is_checked_as_another():
    @dataclass(frozen=True)
    class Local(fl.ContactLaw):
        k: float = fl.parameter(1e3, meaning="stiffness", range=(1.0, 1e4))

        def force(self, penetration):
            return self.k * penetration

    fl.testing.check_law(Local())


def test_messages_are_short_whatever_they_show():
    for value in (
        10**400,
        10**5000,
        list(range(10**6)),
        "x" * 10**6,
        np.zeros((50, 50, 50)),
        {1: "x" * 10**6},
    ):
        assert len(abbreviate(value)) < 200
