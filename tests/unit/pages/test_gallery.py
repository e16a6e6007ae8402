"""A folder of pages: written once, with an index that says what has no page and why."""

import pytest

import frictionlab as fl
from frictionlab.cli import command
from frictionlab.pages import page_data
from frictionlab.pages.gallery import LibraryScene, export_gallery

OSCILLATOR = LibraryScene("FreeCoulomb()", "classics", fl.FreeCoulomb(), "dry friction alone")
BALL = LibraryScene("BouncingBall()", "classics", fl.BouncingBall(), "infinitely many impacts")


def test_a_page_is_written_once_and_what_has_none_is_said_in_the_index(tmp_path, monkeypatch):
    first = export_gallery(tmp_path / "pages", [OSCILLATOR])
    assert (first.written, first.present, first.refused) == (("FreeCoulomb()",), (), {})
    page = tmp_path / "pages" / "FreeCoulomb.html"
    before = page.stat().st_mtime_ns
    monkeypatch.setattr(page_data, "MAX_MODES", 0)
    again = export_gallery(tmp_path / "pages", [OSCILLATOR, BALL])
    assert (again.written, again.present) == ((), ("FreeCoulomb()",))
    assert page.stat().st_mtime_ns == before
    assert list(again.refused) == ["BouncingBall()"]
    assert again.refused["BouncingBall()"] in again.index.read_text(encoding="utf-8")
    page.write_text("of another version", encoding="utf-8")
    assert export_gallery(tmp_path / "pages", [OSCILLATOR]).refused.keys() == {"FreeCoulomb()"}


@pytest.mark.parametrize("options", [["-o", "a.html"], ["--model", "DenHartog"], ["--set", "m=2"]])
def test_a_folder_of_all_has_no_option_of_one_model(options, tmp_path, capsys):
    with pytest.raises(SystemExit):
        command.main(["page", "--all", str(tmp_path), *options])
    assert f"--all must have no {options[0]}" in capsys.readouterr().err
