"""Commands beside `run`: help, figures, films and sounds, the page of the paper, the course, warming up."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.io import wavfile

import frictionlab as fl
from frictionlab.cli import command
from frictionlab.cli.command import build_parsers, main, program_parser
from frictionlab.paper import report
from frictionlab.paper.scenes import IMPACTS
from frictionlab.paper.step_sizes import StepSeries, StepStudy

HELP = """
import sys
from frictionlab.cli.command import main
for command in sys.argv[1:]:
    try: main([command, '--help'])
    except SystemExit as ended: assert ended.code == 0
heavy = {'numpy', 'scipy', 'sympy', 'numba', 'matplotlib'} & set(sys.modules)
sys.exit(str(heavy) if heavy else 0)
"""


def test_help_loads_nothing_heavy():
    commands = sorted(build_parsers()[1])
    program = [sys.executable, "-c", HELP, *commands]
    said = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    assert [line.split()[2] for line in said.splitlines() if line.startswith("usage: ")] == commands


def test_the_parser_that_completes_in_shells_is_that_of_the_command():
    assert program_parser().prog == "frictionlab"
    assert all(f"    {name}" in program_parser().format_help() for name in build_parsers()[1])


@pytest.mark.slow
def test_a_figure_is_described_and_written(tmp_path, capsys):
    path = tmp_path / "six.png"
    assert command.main(["figure", "6", "-o", str(path)]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Fig. 6:")
    assert out.endswith(f"\nPicture in {path}\n")
    assert err == ""
    assert path.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
def test_without_a_file_the_number_names_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command.main(["figure", "2"]) == 0
    assert capsys.readouterr().out.endswith("Picture in fig2.png\n")
    assert [path.name for path in tmp_path.iterdir()] == ["fig2.png"]


@pytest.mark.slow
def test_its_numbers_as_json(tmp_path, capsys):
    path = tmp_path / "six.png"
    assert command.main(["figure", "6", "-o", str(path), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["summary"] == list(fl.paper.figure(6).summary)
    assert (said["number"], said["file"]) == (6, str(path))
    assert path.exists()


@pytest.mark.slow
def test_a_film_has_the_frames_that_were_asked_for(tmp_path, capsys):
    file = tmp_path / "ball.gif"
    words = ["--model", "BouncingBall", "--t-end", "1", "--window", "0.5", "--speed", "0.5", "--fps", "6"]
    assert main(["animate", *words, "-o", str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["file"] == str(file)
    with Image.open(file) as image:
        assert image.n_frames == 7  # a second with six frames, and the last instant
        assert image.info["duration"] in (160, 170)


def test_a_sound_has_the_samples_of_the_run(tmp_path, capsys):
    file = tmp_path / "slider.wav"
    words = ["--set", "mu_k=1.2", "--t-end", "2", "--signal", "friction_force", "-q"]
    assert main(["sound", *words, "-o", str(file)]) == 0
    assert capsys.readouterr().out == f"wrote {file}\n"
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.2), 2.0, progress=False)
    expected = fl.listen(run, "friction_force")
    rate, samples = wavfile.read(file)
    assert rate == expected.rate
    assert np.abs(samples / 32767 - expected.samples).max() < 1e-4


ROOT = Path(__file__).parents[3]
NOTEBOOKS = sorted(path.name for path in ROOT.glob("tutorials/*.ipynb"))
DATA = sorted(path.name for path in ROOT.glob("tutorials/diagrams/*"))


def test_notebooks_and_their_data_are_copied_as_they_are(tmp_path, capsys):
    folder = tmp_path / "new" / "lessons"
    assert main(["course", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notebooks"] == NOTEBOOKS
    assert sorted(path.name for path in folder.iterdir()) == sorted([*NOTEBOOKS, "diagrams", "diagrams.py"])
    assert sorted(path.name for path in (folder / "diagrams").iterdir()) == DATA
    for name in [*NOTEBOOKS, "diagrams.py", *(f"diagrams/{name}" for name in DATA)]:
        assert (folder / name).read_bytes() == (ROOT / "tutorials" / name).read_bytes()


def test_models_of_the_kept_diagrams_are_those_of_this_version():
    """Where a law has another name, `python tutorials/diagrams.py` writes the files anew."""
    diagrams = [
        path for path in ROOT.glob("tutorials/diagrams/*.jsonl") if b'"parameter"' in path.read_bytes()
    ]
    assert len(diagrams) == 7
    for path in diagrams:
        model = fl.load_bifurcation(path).model
        assert model == model.replace()


def test_work_in_the_folder_is_not_lost(tmp_path, capsys):
    assert main(["course", str(tmp_path)]) == 0
    (tmp_path / NOTEBOOKS[1]).write_text("my answers")
    (tmp_path / NOTEBOOKS[2]).unlink()
    capsys.readouterr()
    assert main(["course", str(tmp_path)]) == 1
    captured = capsys.readouterr()
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert f"has other versions of {NOTEBOOKS[1]}: take a new folder" in captured.err
    assert (tmp_path / NOTEBOOKS[1]).read_text() == "my answers"


def test_warmup_says_what_runs(capsys):
    assert main(["warmup", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["solver"] in ("compiled ahead of time", "compiled by numba", "plain Python")
    assert said["second_run"] > 0
    assert main(["warmup"]) == 0
    assert capsys.readouterr().out.startswith("Ready.")


MADE_UP = StepStudy(
    np.array([0.4, 1.4]),
    tuple(
        StepSeries(step, impact, ("equilibrium", "periodic"), np.array([0.0, 0.01]), np.array([np.nan, 3.5]))
        for impact in IMPACTS
        for step in (2e-4, None)
    ),
)


@pytest.fixture
def small(monkeypatch):
    """Two claims, one figure of linear stability, and a study of step sizes made up."""
    monkeypatch.setattr(report, "EVERY_CLAIM", ("C1", "C8"))
    monkeypatch.setattr(report, "figure_variants", lambda: iter([(6, "exact")]))
    monkeypatch.setattr(report, "step_study", lambda setting: MADE_UP)


@pytest.mark.slow
def test_a_page_with_claims_and_pictures(tmp_path, capsys, small):
    assert command.main(["reproduce", "--quick", "-o", str(tmp_path / "docs"), "-q"]) == 0
    out, err = capsys.readouterr()
    page, image = tmp_path / "docs" / "reproduction.md", "images/reproduction/fig06.png"
    assert out == f"Page in {page}\n"
    assert err == ""
    text = page.read_text(encoding="utf-8")
    assert "frictionlab reproduce` --quick" in text.replace("\n", " ")
    assert "2 claims: reproduced 2." in text
    assert '<summary><b>C8</b> <span class="verdict verdict-reproduced">✔ reproduced</span> Fig. 6: ' in text
    assert f"![Fig. 6]({image})" in text
    picture = page.parent / image
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert 5_000 < picture.stat().st_size < 150_000
    steps = (tmp_path / "docs" / "step-size.md").read_text()
    assert "| 0.0002 | 0, 0 | 0, 0 |" in steps
    assert (page.parent / "images/reproduction/step-size.png").exists()


def test_every_figure_in_every_way_that_makes_a_difference():
    pairs = list(report.figure_variants())
    assert len(pairs) == len(set(pairs)) == 5 + 2 * 2 + 10 * 3
    assert {n for n, _ in pairs} == set(range(2, 19))
    assert [way for n, way in pairs if n == 13] == ["exact", "paper-algorithm"]


def test_ctrl_c_is_told_by_the_exit_status(tmp_path, capsys, small, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(report, "check", interrupted)
    assert command.main(["reproduce", "-o", str(tmp_path), "-q"]) == 130
    assert capsys.readouterr().err == "frictionlab: stopped by ctrl-C\n"
