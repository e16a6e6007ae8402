"""What is derived of a library's model is kept: later processes need no sympy, and compute the same bits."""

import json
import os
import subprocess
import sys
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab import cache_folder
from frictionlab.cli.shipped_structures import shipped_models
from frictionlab.components import FrictionLaw
from frictionlab.models import kept_structures
from frictionlab.models.automaton_of_model import automaton_of_structure
from frictionlab.models.kept_structures import derivations_of

ROOT = Path(__file__).parents[2]
# Of each run the bits of all that a picture or a summary asks for.
RUN = """
import json, sys
import frictionlab as fl
from frictionlab import Coulomb, ExponentialDecay, Stribeck, HertzContact, RestitutionImpact
found = []
for text in {models!r}:
    model = eval(text)
    run = fl.simulate(model, 0.4, progress=False)
    outputs = [run.output(name, [0.1, 0.3]).tolist() for name in run.automaton.outputs]
    found.append([run.final_state.tolist(), run.events.t.tolist(), list(run.events.target), outputs])
    if model.statics is not None:
        modes = fl.eigenvalues(model)
        found.append([modes.values.real.tolist(), modes.values.imag.tolist(), modes.equilibrium.q.tolist()])
        found[-1] += [[c.value, c.frequency] for c in fl.stability_changes(model, "mu_k", (0.0, 3.0))]
        found[-1] += [fl.root_locus(model, "mu_k", [0.1, 0.2]).values.imag.tolist()]
        found[-1] += [fl.stability_map(model, ("mu_k", [0.1, 2.0]), ("k1", [1e4, 2e4])).growth.tolist()]
print(json.dumps(["sympy.core" in sys.modules, found]))
"""
MODELS = (
    "fl.SliderOnBelt(mu_k=1.4)",
    "fl.SliderOnBelt(mu_k=1.4).without('cubic', 'geometry')",
    "fl.SliderOnBelt(v=-1.0).without('nonsmooth')",
    "fl.SliderOnBelt(contact=HertzContact(), friction=Stribeck())",
    "fl.SliderOnBelt(impact=RestitutionImpact(e=0.0))",
    "fl.SliderOnBelt(impact=RestitutionImpact(e=0.5))",
    "fl.DenHartog(F=1.2)",
    "fl.MassOnBelt(friction=ExponentialDecay())",
    "fl.ImpactOscillator()",
    "fl.ModeCoupling()",
)


def in_a_process(code, folder):
    """What it prints as JSON."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "FRICTIONLAB_CACHE_DIR": str(folder)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


# Of each model of the table the bits of what the commands run, eig and critical print, and why there is none.
TABLE = """
import json, sys
import frictionlab as fl
from frictionlab.cli.parsing import model_of
def answer(function, *asked):
    try:
        return function(*asked)
    except ValueError as error:
        return str(error)
def found_of(model):
    run = fl.simulate(model, 2.0, progress=False)
    name, value = next((n, v) for n, v in model.parameters.items() if v)
    points, modes = answer(fl.equilibria, model), answer(fl.eigenvalues, model)
    shown = [[*e.q.tolist(), e.penetration, e.normal_force, e.friction_force, e.residual] for e in points]
    changes = answer(fl.stability_changes, model, name, (0.5 * value, 1.5 * value))
    outputs = [run.output(name, [0.1, 0.3]).tolist() for name in run.automaton.outputs]
    values = modes if isinstance(modes, str) else [modes.values.real.tolist(), modes.values.imag.tolist()]
    moments = [run.events.t.tolist(), list(run.events.target), dict(run.time_in_mode)]
    return [repr(model), run.final_state.tolist(), moments, outputs, repr(shown), values, repr(changes)]
rows = [found_of(model_of(row.call)) for row in fl.list_models("classics")]
rows[0].append(fl.explore(fl.SliderOnBelt(mu_k=1.4)).widget.picture["friction"]["at"])
print(json.dumps(["sympy.core" in sys.modules, rows]))
"""


@pytest.mark.slow
def test_no_model_of_the_table_needs_sympy_in_a_second_process(tmp_path):
    """Nor an explorer, with its friction curve."""
    pytest.importorskip("anywidget")
    derived, first = in_a_process(TABLE, tmp_path)
    again, second = in_a_process(TABLE, tmp_path)
    assert (derived, again) == (True, False)
    assert second == first
    assert len(first) == len(fl.list_models("classics"))
    eigenvalues = [row[5] for row in first]
    assert sum(isinstance(values, list) for values in eigenvalues) > 5


@pytest.mark.parametrize("x0", [[0.1, 0.0, 0.0, 0.0], [0.3, -0.2, 0.0, 0.4]])
def test_a_run_with_all_modes_kept_is_one_that_derives_those_it_comes_to(x0):
    late = fl.TwoBlocks().automaton()
    derived = automaton_of_structure.__wrapped__(fl.TwoBlocks().structure_key)
    few = replace(derived, parameters=late.parameters)
    run, other = (fl.solve(each, 20.0, x0=x0) for each in (late, few))
    assert late.derivations is not None
    assert late.on_demand
    assert set(few.modes.derived) < set(run.mode_names)
    assert run.final_state.tolist() == other.final_state.tolist()
    for name in ("t", "guard", "target", "state"):
        assert getattr(run.events, name).tolist() == getattr(other.events, name).tolist()
    assert dict(run.time_in_mode) == dict(other.time_in_mode)
    assert late.names == few.names
    assert repr(late) == repr(few)


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A folder that a process has filled, and what it has found."""
    folder = tmp_path_factory.mktemp("cache")
    return folder, *in_a_process(RUN.format(models=MODELS), folder)


def structure_files(folder):
    return sorted(folder.rglob("*.structure"))


@pytest.mark.slow
def test_a_second_process_has_the_same_bits_without_sympy(filled):
    folder, derived, first = filled
    files = {path: path.read_bytes() for path in structure_files(folder)}
    again, second = in_a_process(RUN.format(models=MODELS), folder)
    assert (derived, again) == (True, False)
    assert len(first) == len(MODELS) + 6
    assert second == first
    assert {path: path.read_bytes() for path in structure_files(folder)} == files
    assert len(files) >= len(MODELS)


@pytest.mark.slow
def test_a_damaged_file_is_derived_anew(filled, tmp_path):
    *_, first = filled
    model = MODELS[:1]
    assert in_a_process(RUN.format(models=model), tmp_path) == [True, first[:2]]
    (path,) = structure_files(tmp_path)
    whole = path.read_bytes()
    for damaged in (b"", whole[:-1], whole.replace(b'"program"', b'"pr0gram"', 1)):
        path.write_bytes(damaged)
        assert in_a_process(RUN.format(models=model), tmp_path) == [True, first[:2]]
        assert path.read_bytes() == whole
    path.chmod(0o666)  # others may have written it
    assert in_a_process(RUN.format(models=model), tmp_path) == [True, first[:2]]
    assert in_a_process(RUN.format(models=model), tmp_path) == [False, first[:2]]


WRITE_ARCHIVE = """
from pathlib import Path
import frictionlab as fl
from frictionlab import Stribeck, HertzContact
from frictionlab.cli.shipped_structures import write_archive
write_archive(Path({path!r}), (eval(text) for text in {models!r}))
print(1)
"""
USE_ARCHIVE = """
from pathlib import Path
from frictionlab.models import kept_structures
kept_structures.ARCHIVE = Path({path!r})
"""


@pytest.mark.slow
def test_a_first_process_reads_what_a_wheel_carries(filled, tmp_path):
    """No sympy, the same bits, and nothing is written; of other sources it is not read."""
    *_, first = filled
    chosen, path = MODELS[:2], tmp_path / "structures.zip"
    in_a_process(WRITE_ARCHIVE.format(path=str(path), models=chosen), tmp_path / "unused")
    run = USE_ARCHIVE.format(path=str(path)) + RUN.format(models=chosen)
    assert in_a_process(run, tmp_path / "cache") == [False, first[:4]]
    assert structure_files(tmp_path) == []
    for spoil in (of_other_sources, damaged):
        spoil(path)
        assert in_a_process(run, tmp_path / spoil.__name__) == [True, first[:4]]
        assert len(structure_files(tmp_path / spoil.__name__)) >= 2


def of_other_sources(path):
    with zipfile.ZipFile(path, "a") as archive:
        archive.comment = b"0" * len(archive.comment)


def damaged(path):
    path.write_bytes(path.read_bytes()[:-100])


def test_a_wheel_carries_the_models_of_the_table():
    """With their switches."""
    calls = [row.call for row in fl.list_models("classics")]
    chosen = [repr(model) for model in shipped_models()]
    assert len(chosen) == len({*chosen}) > 2 * len(calls)
    assert sum(text.startswith("SliderOnBelt(") for text in chosen) == 2**3


@dataclass(frozen=True, repr=False)
class Weak(FrictionLaw):
    mu_k: float = fl.parameter(0.3)
    mu_s: float = fl.parameter(0.5)

    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force / (1 + speed)

    def static_limit(self, normal_force):
        return self.mu_s * normal_force


@dataclass(frozen=True, repr=False)
class Renamed(fl.Coulomb):
    """A law of one's own, although nothing is changed."""


@pytest.mark.parametrize("law", [Weak(), Renamed()], ids=lambda law: type(law).__name__)
def test_nothing_is_kept_of_a_law_of_ones_own(law):
    key = fl.SliderOnBelt(friction=law).structure_key
    assert not derivations_of(key).keeps


def test_a_law_whose_method_was_exchanged_is_ones_own(monkeypatch, tmp_path):
    monkeypatch.setenv("FRICTIONLAB_CACHE_DIR", str(tmp_path))
    key = fl.MassOnBelt().structure_key
    derivations_of.cache_clear()
    assert derivations_of(key).keeps
    monkeypatch.setattr(fl.Coulomb, "kinetic", lambda self, normal_force, speed: 0 * normal_force)
    derivations_of.cache_clear()
    assert not derivations_of(key).keeps
    monkeypatch.undo()
    derivations_of.cache_clear()


def test_an_edit_of_a_source_or_another_sympy_names_another_folder(monkeypatch, tmp_path):
    before = kept_structures.sources().digest
    assert len(before) == cache_folder.DIGEST_LENGTH
    (tmp_path / "release.py").write_text("__version__ = '0'")
    monkeypatch.setattr(kept_structures, "_beside", lambda package, name: tmp_path / "release.py")
    found = {before, kept_structures.sources().digest}
    (tmp_path / "models").mkdir()
    monkeypatch.setattr(kept_structures, "SOURCES", ("models",))
    monkeypatch.setattr(kept_structures, "PACKAGE", tmp_path)
    for text in ("k = 1", "k = 2"):
        (tmp_path / "models" / "law.py").write_text(text)
        found.add(kept_structures.sources().digest)
    assert len(found) == 4
    (tmp_path / "models" / "law.py").unlink()  # byte code alone is installed, or the package is a zip file
    assert kept_structures.sources() == ("", (), ())


def test_nothing_is_kept_once_a_source_was_edited(monkeypatch, tmp_path):
    """A process would keep, under the name of the new source, what the old one has derived."""
    (tmp_path / "models").mkdir()
    law = tmp_path / "models" / "law.py"
    law.write_text("k = 1")
    monkeypatch.setattr(kept_structures, "SOURCES", ("models",))
    monkeypatch.setattr(kept_structures, "PACKAGE", tmp_path)
    monkeypatch.setattr(kept_structures, "LOADED", kept_structures.sources())
    path = tmp_path / "x.structure"
    kept = kept_structures.Derivations(path)
    kept.keep("one", 1)
    law.write_text("k = 22")
    kept.keep("two", 2)
    again = kept_structures.Derivations(path)
    assert (again.get("one"), again.get("two")) == (1, None)


def test_an_automaton_derived_late_is_like_any_other():
    model = fl.SliderOnBelt(mu_k=1.4)
    late, other = model.automaton(), model.replace(mu_k=2.0).automaton()
    full = late.derived()
    assert late.state_names == tuple(symbol.name for symbol in full.states)
    assert late.names == full.names
    assert late.outputs == full.outputs
    assert late.values == {symbol.name: value for symbol, value in full.parameters.items()}
    assert late.modes is other.modes is full.modes
    assert repr(late) == repr(full)
    changed = late.replace(mu_k=1.9)
    assert changed.values["mu_k"] == 1.9 == {s.name: v for s, v in changed.parameters.items()}["mu_k"]
    with pytest.raises(TypeError, match="did you mean"):
        late.replace(mu_kk=1.0)
    state = np.zeros(10)
    runs = [fl.solve(each, 0.1, x0=state).final_state.tolist() for each in (late, full)]
    assert runs[0] == runs[1]
