"""`frictionlab completion` prints scripts that shells complete by; those that are installed are asked."""

import shutil
import subprocess
import sys

import pytest

from frictionlab.cli.command import build_parsers, main
from frictionlab.cli.parsing import model_names

COMMANDS = sorted(build_parsers()[1])
ASK_BASH = """
COMP_WORDS=({words} "{last}"); COMP_CWORD={count}
_frictionlab; printf '%s\\n' "${{COMPREPLY[@]}}"
"""
EXPECTED = [
    ([], "", COMMANDS),
    ([], "cr", ["critical"]),
    (["run", "--model"], "Den", ["DenHartog"]),
    (["models"], "", model_names()),
    (["completion"], "", ["bash", "fish", "zsh"]),
    (["eig"], "--wi", ["--without"]),
]


def script(shell, capsys):
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


def asked(command, text):
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\n")


@pytest.mark.skipif(sys.platform == "win32", reason="its bash may be another system's")
@pytest.mark.parametrize(("words", "last", "expected"), EXPECTED)
def test_bash_completes(words, last, expected, capsys):
    ask = ASK_BASH.format(words=" ".join(["frictionlab", *words]), last=last, count=len(words) + 1)
    found = asked(["bash"], script("bash", capsys) + ask)
    assert sorted(filter(None, found)) == sorted(expected)


@pytest.mark.parametrize(("words", "last", "expected"), EXPECTED)
def test_fish_completes(words, last, expected, capsys):
    line = " ".join(["frictionlab", *words, last])
    found = asked(["fish", "--no-config"], f"{script('fish', capsys)}\ncomplete --do-complete '{line}'\n")
    names = [row.split("\t")[0] for row in found if row]
    assert [name for name in expected if name not in names] == []
    assert [name for name in names if name in {*COMMANDS, *model_names()} - {*expected}] == []


def test_zsh_reads_its_script(capsys):
    stub = "compdef() { defined=$2 }\n"
    found = asked(["zsh", "-f"], f"{stub}{script('zsh', capsys)}\nprint $defined; whence -w _frictionlab\n")
    assert found[:2] == ["frictionlab", "_frictionlab: function"]


def test_another_shell_is_refused(refused):
    assert "'tcsh'" in refused("completion", "tcsh")
