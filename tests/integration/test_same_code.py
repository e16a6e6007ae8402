"""Which changes leave the code as it is, so that `.ci/run` need not run notebooks and the browser."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / ".ci" / "same_code.py"
CODE = '"""A file."""\n\n\ndef f(x):\n    """Twice x."""\n    return 2 * x  # no more\n'


@pytest.fixture
def clone(tmp_path):
    def git(*arguments):
        subprocess.run(("git", *arguments), cwd=tmp_path, check=True, capture_output=True)

    (tmp_path / "f.py").write_text(CODE)
    (tmp_path / "README.md").write_text("words")
    git("init")
    git("add", ".")
    git("-c", "user.name=a", "-c", "user.email=a@b.c", "commit", "-m", "first")
    return tmp_path


def is_same(clone, commit="HEAD"):
    return subprocess.run([sys.executable, SCRIPT, commit], cwd=clone, check=False).returncode == 0


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("Twice x.", "Two x.", True),
        pytest.param("# no more", "# that is all", True, marks=pytest.mark.slow),
        ('    """Twice x."""\n', "", False),  # a function that has none has another __doc__
        ("2 * x", "3 * x", False),
        pytest.param("2 * x", "2 *", False, marks=pytest.mark.slow),
    ],
)
def test_a_change_of_a_python_file(clone, old, new, same):
    assert is_same(clone)
    (clone / "f.py").write_text(CODE.replace(old, new))
    assert is_same(clone) == same


def test_other_files(clone):
    (clone / "README.md").write_text("other words")
    assert is_same(clone)
    assert not is_same(clone, "unknown")
    (clone / "data.json").write_text("{}")
    assert not is_same(clone)
    (clone / "data.json").unlink()
    (clone / "f.py").unlink()
    assert not is_same(clone)
