"""`frictionlab figure`: what it prints, writes and returns."""

import json

import pytest

import frictionlab as fl
from frictionlab.cli import command


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
