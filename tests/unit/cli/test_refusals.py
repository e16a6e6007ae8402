"""Bad arguments of every command: one line that names the argument and the cure, and code 2."""

import json

import pytest

from frictionlab.cli.command import main

BAD = {
    "run --set mu_k=nan": "mu_k must be a finite number",
    "run --set mu_k=-1": "mu_k must be at least 0, got -1.0: raise mu_k",
    "run --set mu_k=abc": "--set takes a parameter, = and a number",
    "run --set": "expected at least one argument",
    "run --set M=-1": "M must be greater than 0, got -1.0",
    "run --set mu_s=1": "mu_s must be at least mu_k (1.4), got 1.0",
    "run --outptu a.png": "unknown option '--outptu': did you mean '--output'?",
    "run --nope 1": "unknown option '--nope': see frictionlab run --help; parameters are --set mu_k=1.4",
    "run extra": "unexpected argument 'extra'",
    "run --method tayler": "did you mean 'taylor'?",
    "run --method DOP853 --step 1": "--step is an option of --method rk4",
    "run --method rk4 --tol 1e-9": "--tol is no option of --method rk4",
    "run --tol 2": "tol must be",
    "run --max-steps 0": "max_steps must be",
    "run --without geometri": "did you mean 'geometry'?",
    "run --without cubic --set k_nl=3": "'k_nl': it belongs to CubicContact",
    "run --set e=0.5": "'e': it belongs to RestitutionImpact",
    "run --t-end 0": "--t-end must be",
    "run --t-end nan": "--t-end must be",
    "run --x0 nea": "did you mean 'near'?",
    "run --x0 1,2": "10 numbers (x1, y1",
    "run --x0 near --set F=0": "F_N > 0",
    "run -o /no/such/folder/a.png": "there is no '/no/such/folder'",
    "run -o a.xyz": "-o must end in one of .png",
    "run --save /no/such/folder/a": "there is no '/no/such/folder'",
    "run --model DenHartg": "did you mean 'DenHartog'?",
    "run --model Nothing": "`frictionlab models` says what each is",
    "run --model DenHartog --set mu=1": "DenHartog has no parameter 'mu': did you mean",
    "run --model MassOnBelt --without geometry": "got 'geometry'",
    "run --model MassOnBelt(friction=Stribek())": "got 'Stribek()': write MassOnBelt(friction=Stribeck())",
    "run --model MassOnBelt(c=open": "close what is open",
    "run --model MassOnBelt(c=__import__('os'))": "laws by their names",
    "run --set mu_k": "got 'mu_k': write --set mu_k=1.4",
    "run --set mu_k=": "got 'mu_k=': write --set mu_k=1.4",
    "eig --model BouncingBall": "must leave a coordinate free to have eigenvalues",
    "eig --model ImpactOscillator": "must have a mode with an equilibrium",
    "eig --set mu_kk=1": "did you mean 'mu_k'?",
    "critical mu 0 4": "did you mean 'mu_s'?",
    "critical mu_k 4 0": "bounds",
    "critical mu_k": "required: LOW, HIGH",
    "models DenHartg": "NAME must be one of",
    "animate -o film.mpg": "-o must end in .gif or .html",
    "sound -o sound.mp3": "-o must end in .wav",
    "animate --model MassOnBelt --x0 nea": "did you mean 'near'?",
    "sound --t-end 0": "--t-end must be",
    "sound --t-end 1 --signal friction": "signal must be one of",
    "course": "required: FOLDER",
    "warmup now": "unexpected argument 'now'",
    "app --port 0": "--port must be from 1 to 65535, got 0: leave it out for 8866",
    "app --port 70000": "--port must be from 1 to 65535, got 70000",
    "app --port many": "argument --port: invalid int value: 'many'",
    "app --no-browsr": "unknown option '--no-browsr': did you mean '--no-browser'?",
    "app 9000": "unexpected argument '9000'",
    "figure 19": "the figure must be one of 2, 3, 4, 5, 6, 7, 8,",
    "figure -1": "17, 18, got -1",
    "figure two": "argument N: invalid int value: 'two'",
    "figure": "the following arguments are required: N",
    "figure 2 -o a.xyz": "-o must end in one of .png",
    "figure 2 -o /no/such/folder/a.png": "there is no '/no/such/folder'",
    "figure 2 --outptu a.png": "unknown option '--outptu': did you mean '--output'?",
    "reproduce --workers 0": "--workers must be an integer, at least 1, got 0",
    "reproduce --quik": "unknown option '--quik': did you mean '--quick'?",
}


@pytest.mark.plain_python
@pytest.mark.parametrize(("words", "message"), BAD.items(), ids=BAD)
def test_bad_arguments_end_with_one_line_and_code_2(words, message, refused):
    assert message in refused(*words.split())


OWN = """\
import sympy as sp
import frictionlab as fl
from beside import STIFFNESS


@fl.model
class Spring(fl.MechanicalModel):
    k: float = STIFFNESS
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(v.x**2 / 2, self.k * q.x**2 / 2)


x, y, a = sp.symbols("x y a")
relay = fl.HybridAutomaton((x, y), (fl.Mode("on", (y, -a * x)),), {a: 4.0})
mass = fl.Structure([[1.0]], [[4.0]])
"""


@pytest.fixture
def folder(tmp_path):
    files = {"own.py": OWN, "beside.py": "STIFFNESS = 4.0", "bad.py": "import not_there", "none.py": "a = 1"}
    files["exit.py"] = "raise SystemExit(0)"
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_models_structures_and_automata_of_a_file_of_ones_own(folder, capsys):
    for name, states in (("Spring", 2), ("relay", 2), ("mass", 2)):
        assert main(["eig", "--model", f"{folder}/own.py:{name}", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)["eigenvalues"]
        assert sorted(abs(one["imag"]) for one in found) == pytest.approx(states * [2.0])
    page = folder / "relay.html"
    assert main(["page", "--model", f"{folder}/own.py:relay", "--set", "a=1", "-o", str(page)]) == 0
    assert "relay" in page.name
    assert page.stat().st_size > 100_000


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("own.py", "own.py, got no name: write"),
        ("own.py:Sprng", "got Sprng: did you mean 'Spring'?"),
        ("no.py:Spring", "needs an existing file, there is no"),
        ("bad.py", "bad.py ends in ModuleNotFoundError: No module named 'not_there'"),
        ("exit.py", "exit.py ends in SystemExit: 0"),
        ("none.py:a", "none.py has none: write one"),
        ("own.py:relay --without cubic", "is of class HybridAutomaton: leave it out"),
    ],
)
def test_what_a_file_of_ones_own_lacks_is_told(file, message, folder, refused):
    assert message in refused("page", "--model", *f"{folder}/{file}".split())


def test_a_folder_is_no_file(tmp_path, refused):
    folder = tmp_path / "a.png"
    folder.mkdir()
    assert "is a folder" in refused("run", "-o", str(folder))


@pytest.mark.parametrize("option", ["-o", "--resume"])
def test_a_file_is_no_folder(option, tmp_path, refused):
    file = tmp_path / "file"
    file.write_text("")
    assert f"{option} must be a folder" in refused("reproduce", option, str(file))
