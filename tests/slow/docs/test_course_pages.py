"""What the site makes of the course: solutions stay closed, pages stand where explorers would be."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
INDEX, *NOTEBOOKS = sorted(ROOT.glob("tutorials/*.ipynb"))
CONF = "import sys\nsys.path.insert(0, {path!r})\nextensions = ['myst_nb']\nnb_execution_mode = 'off'\n"
OPEN, CLOSED = '<details class="solution">', "</details>"


@pytest.fixture(scope="module")
def extension():
    """The module of the site's sources, which is no package."""
    sys.path.insert(0, str(ROOT / "docs" / "_extensions"))
    try:
        import course_cells

        yield course_cells
    finally:
        sys.path.remove(str(ROOT / "docs" / "_extensions"))


def cells_of(path):
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


def source(cell):
    return "".join(cell["source"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_exercise_has_one_block_with_all_of_its_solution(path, extension):
    cells = extension.fold_solutions(cells_of(path))
    exercises = next(source(cell) for cell in cells if cell["id"] == "exercises")
    numbers = re.findall(r"^(\d+)\. ", exercises, flags=re.MULTILINE)
    opened = [source(cell) for cell in cells if source(cell).startswith(OPEN)]
    assert [re.search(r"Solution (\d+)", text)[1] for text in opened] == numbers
    inside = False
    for cell in cells:
        text = source(cell)
        if text.startswith(OPEN) or text == CLOSED:
            assert inside == (text == CLOSED)  # one after the other, never within each other
            inside = not inside
        else:
            assert inside == cell["id"].startswith("solution")
            assert "<details>" not in text or not inside
    assert not inside


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_in_jupyter_code_and_output_of_a_solution_are_hidden(path):
    code = [c for c in cells_of(path) if c["cell_type"] == "code" and c["id"].startswith("solution")]
    assert code
    assert all(c["metadata"]["jupyter"] == {"source_hidden": True, "outputs_hidden": True} for c in code)


class Seen(HTMLParser):
    """The text of a page outside of what is closed."""

    def __init__(self):
        super().__init__()
        self.depth, self.words, self.hidden, self.in_summary = 0, [], [], False

    def handle_starttag(self, tag, attrs):
        self.depth += tag == "details"
        self.in_summary = tag == "summary"

    def handle_endtag(self, tag):
        self.depth -= tag == "details"
        self.in_summary = self.in_summary and tag != "summary"

    def handle_data(self, data):
        (self.hidden if self.depth and not self.in_summary else self.words).append(data)


def cell(name, text, output=None):
    """A cell of text, or with an output one of code that has run."""
    if output is None:
        return {"cell_type": "markdown", "id": name, "metadata": {}, "source": text}
    shown = {"output_type": "stream", "name": "stdout", "text": output}
    return {
        "cell_type": "code",
        "id": name,
        "metadata": {"tags": ["solution"]},
        "source": text,
        "outputs": [shown],
        "execution_count": 1,
    }


def test_a_solution_and_what_it_prints_are_seen_only_when_it_is_opened(tmp_path, extension):
    pytest.importorskip("myst_nb", reason="the site is built by it")
    words = "<details>\n<summary>Solution 1, in words</summary>\n\nSecret $x = 4$ words.\n\n</details>"
    cells = [
        cell("title", "# A lesson"),
        cell("exercises", "## Exercises\n\n1. How much is it?"),
        cell("solution-1-text", words),
        cell("solution-1", "print(secret_code)", "secret output"),
        cell("end", "After the solutions."),
    ]
    about = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    about["language_info"] = {"name": "python"}
    page = {"cells": extension.fold_solutions(cells), "metadata": about, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "index.ipynb").write_text(json.dumps(page))
    (tmp_path / "conf.py").write_text(CONF.format(path=str(ROOT / "docs" / "_extensions")))
    command = [sys.executable, "-m", "sphinx", "-W", "-b", "html", str(tmp_path), str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    seen = Seen()
    seen.feed((tmp_path / "site" / "index.html").read_text(encoding="utf-8"))
    visible, hidden = " ".join(seen.words), " ".join(seen.hidden)
    assert seen.depth == 0
    assert "How much is it?" in visible
    assert "After the solutions." in visible
    assert "Solution 1" in visible
    for secret in ("Secret", "secret_code", "secret output"):
        assert secret in hidden
        assert secret not in visible


def test_explorers_that_have_a_page_leave_no_note(extension):
    for path in NOTEBOOKS:
        cells = cells_of(path)
        before = len(cells)
        extension.put_live_page(path.stem, cells, "NOTE")
        live = [one for one in cells if one["id"] == "live"]
        assert len(live) == len(cells) - before == (path.stem in extension.LIVE)
        for one in live:
            explorer = cells[cells.index(one) - 1]
            assert "fl.explore" in source(explorer)
            assert "remove-output" in explorer["metadata"]["tags"]
            assert source(one).count("NOTE") == 1


LECTURED = "00-one-mass", "01-first-run", "02-why-brakes-squeal"  # the 90 minutes of docs/lecturer.md


def slides_of(path):
    """The slides of a notebook, each as its cells."""
    slides = []
    for cell in cells_of(path):
        kind = cell["metadata"].get("slideshow", {}).get("slide_type")
        if kind in ("slide", "subslide"):
            slides.append([cell])
        elif kind == "-":
            slides[-1].append(cell)
        else:
            assert kind == "skip", f"{path.name}: {cell['id']} is neither on a slide nor left out"
    return slides


@pytest.mark.parametrize("name", LECTURED)
def test_nbconvert_makes_these_slides_without_solutions(name):
    nbconvert = pytest.importorskip("nbconvert", reason="slides are made by it")
    nbformat = pytest.importorskip("nbformat", reason="it reads the notebooks; it is not installed")
    path = ROOT / "tutorials" / f"{name}.ipynb"
    exporter = nbconvert.SlidesExporter(exclude_input=True)
    page, _ = exporter.from_notebook_node(nbformat.read(path, as_version=4))
    stacks = sum(slide[0]["metadata"]["slideshow"]["slide_type"] == "slide" for slide in slides_of(path))
    # Slides stand in stacks, one <section> for each stack and one for each slide.
    assert page.count("<section>") == len(slides_of(path)) + stacks
    assert "Solution 1" not in page
    assert "assert " not in page
