"""`frictionlab figure`: what it prints, writes and returns."""

import json

import frictionlab as fl
from frictionlab.cli import command, parsing


def test_a_figure_is_described_and_written(tmp_path, capsys):
    path = tmp_path / "six.png"
    assert command.main(["figure", "6", "-o", str(path)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{fl.paper.figure(6)}\nPicture in {path}\n"
    assert err == ""
    assert path.read_bytes()[:4] == b"\x89PNG"


def test_without_a_file_the_number_names_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command.main(["figure", "2"]) == 0
    assert capsys.readouterr().out.endswith("Picture in fig2.png\n")
    assert [path.name for path in tmp_path.iterdir()] == ["fig2.png"]


def test_a_file_that_cannot_be_written_after_all_does_not_lose_the_numbers(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(parsing, "check_files", lambda chosen: None)
    assert command.main(["figure", "6", "-o", str(tmp_path / "gone" / "a.png")]) == 1
    captured = capsys.readouterr()
    assert captured.out.startswith("Fig. 6")
    assert captured.err.startswith("frictionlab figure: error: ")
    assert captured.err.count("\n") == 1


def test_its_numbers_as_json(tmp_path, capsys):
    path = tmp_path / "six.png"
    assert command.main(["figure", "6", "-o", str(path), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["summary"] == list(fl.paper.figure(6).summary)
    assert (said["number"], said["file"]) == (6, str(path))
    assert path.exists()
