"""`frictionlab course` copies the notebooks and spares what is there; `frictionlab warmup` says what runs."""

import json
from pathlib import Path

import frictionlab as fl
from frictionlab.cli.command import main

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
