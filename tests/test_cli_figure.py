"""`frictionlab figure`: what it prints, writes and returns."""

import subprocess
import sys

import pytest

import frictionlab as fl
from frictionlab import cli
from frictionlab.cli import choices
from frictionlab.paper.registry import EVERY_FIGURE


def failing(argv, capsys):
    """stderr of a command that ends with code 2 before anything is computed."""
    with pytest.raises(SystemExit) as ended:
        cli.main(["figure", *argv])
    assert ended.value.code == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    return captured.err


def test_a_figure_is_described_and_written(tmp_path, capsys):
    path = tmp_path / "six.png"
    assert cli.main(["figure", "6", "-o", str(path)]) == 0
    out, err = capsys.readouterr()
    assert out == f"{fl.paper.figure(6)}\nPicture in {path}\n"
    assert err == ""
    assert path.read_bytes()[:4] == b"\x89PNG"


def test_without_a_file_the_number_names_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["figure", "2"]) == 0
    assert capsys.readouterr().out.endswith("Picture in fig2.png\n")
    assert [path.name for path in tmp_path.iterdir()] == ["fig2.png"]


BAD = {
    "19": "the figure must be one of 2, 3, 4, 5, 6, 7, 8,",
    "-1": "17, 18, got -1",
    "two": "argument N: invalid int value: 'two'",
    "": "the following arguments are required: N",
    "2 -o a.xyz": "-o must end in one of .png",
    "2 -o /no/such/folder/a.png": "there is no '/no/such/folder'",
    "2 --outptu a.png": "unknown option '--outptu': did you mean '--output'?",
}


@pytest.mark.parametrize(("options", "message"), BAD.items(), ids=BAD)
def test_bad_arguments_end_with_one_line_and_code_2(options, message, capsys):
    err = failing(options.split(), capsys)
    assert err.startswith("frictionlab figure: error: ")
    assert err.count("\n") == 1
    assert message in err.replace("\\", "/")


def test_a_file_that_cannot_be_written_after_all_does_not_lose_the_numbers(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(choices, "check_files", lambda chosen: None)
    assert cli.main(["figure", "6", "-o", str(tmp_path / "gone" / "a.png")]) == 1
    captured = capsys.readouterr()
    assert captured.out.startswith("Fig. 6")
    assert captured.err.startswith("frictionlab figure: error: ")
    assert captured.err.count("\n") == 1


def test_help_names_the_figures_and_loads_nothing_heavy(capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main(["figure", "--help"])
    assert ended.value.code == 0
    assert f"the paper's number: {min(EVERY_FIGURE)} to {max(EVERY_FIGURE)}" in capsys.readouterr().out
    code = (
        "import sys\nfrom frictionlab.cli import main\n"
        "try: main(['figure', '--help'])\nexcept SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'sympy', 'numba', 'matplotlib'} & set(sys.modules)\n"
        "sys.exit(str(heavy) if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
