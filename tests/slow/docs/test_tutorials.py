"""Every notebook in tutorials/ runs from its first to its last cell.

Where FRICTIONLAB_EXECUTED names a folder, the executed notebooks are left there for the documentation
site, which then need not execute them once more.
"""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[3]
TUTORIALS = ROOT / "tutorials"
EXECUTED = os.environ.get("FRICTIONLAB_EXECUTED")


@pytest.mark.parametrize("path", sorted(TUTORIALS.glob("*.ipynb")), ids=lambda path: path.name)
def test_notebook_runs(path, monkeypatch):
    monkeypatch.setenv("FRICTIONLAB_PROGRESS", "0")  # bars would stay on the site's pages as widgets
    monkeypatch.setenv("MATPLOTLIBRC", str(ROOT / "docs" / "matplotlibrc"))  # pictures as the site shows them
    notebook = nbformat.read(path, as_version=4)
    resources = {"metadata": {"path": str(TUTORIALS)}}
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources=resources).execute()
    if EXECUTED:
        Path(EXECUTED).mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, Path(EXECUTED) / path.name)
