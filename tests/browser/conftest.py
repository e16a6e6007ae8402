"""axe-core, which finds faults that keep people from using a page, by the rules of WCAG 2."""

import shutil
import subprocess

import pytest

AXE = "axe-core@4.14.1"


@pytest.fixture(scope="session")
def axe(tmp_path_factory):
    """The source of axe-core, by npm."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("npm brings axe-core; it is not installed")
    folder = tmp_path_factory.mktemp("axe")
    command = [npm, "install", "--prefix", str(folder), "--no-audit", "--no-fund", AXE]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"npm could not bring {AXE}: {done.stderr.strip().splitlines()[-1:]}")
    return (folder / "node_modules/axe-core/axe.min.js").read_text(encoding="utf-8")
