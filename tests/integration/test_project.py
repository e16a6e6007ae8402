"""The files around the package agree with it and with each other."""

import ast
import json
import re
import sys
import tomllib
from pathlib import Path

import pytest
from matplotlib import pyplot
from PIL import Image

import frictionlab as fl
from tests.helpers import layout

ROOT = Path(__file__).parents[2]
# Where a package is not called as what it imports.
DISTRIBUTIONS = {"PIL": "pillow", "IPython": "ipython", "jupyter_server": "jupyter-server"}
README = (ROOT / "README.md").read_text(encoding="utf-8")
STARTING = (ROOT / "docs" / "getting-started.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
NOTEBOOKS = sorted(ROOT.glob("tutorials/*.ipynb"))


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)


def readme_blocks(language: str) -> list[str]:
    return blocks(README, language)


def test_every_session_of_nox_is_run():
    tree = ast.parse((ROOT / "noxfile.py").read_text(encoding="utf-8"))
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    sessions = {f.name for f in functions if any("nox.session" in ast.unparse(d) for d in f.decorator_list)}
    scripts = [*ROOT.glob(".ci/*"), *ROOT.glob(".github/workflows/*.yml")]
    texts = "\n".join(path.read_text(encoding="utf-8") for path in scripts)
    called = re.findall(r"\bnox (?:--[\w-]+ )?-s ([\w ]+)", texts)
    by_readme = {"tests", "site"}  # its second and third command, which .ci takes from there
    assert sessions == {*" ".join(called).split(), *by_readme}


def test_files_that_the_architecture_names_are_there():
    """Each by its path from the package or the repository, or by its name beside one that has a path."""
    pages = [ROOT / "docs" / "architecture.md", *ROOT.glob("docs/architecture/*.md")]
    rows = [line for line in pages[0].read_text(encoding="utf-8").splitlines() if "? |" in line]
    texts = [*rows, *(page.read_text(encoding="utf-8") for page in pages)]
    assert len(rows) > 30
    for text in texts:
        names = re.findall(r"`([\w/.-]+(?:/|\.pyi?|\.js|\.json))`", text)
        bases = [ROOT / "frictionlab", ROOT]
        folders = [(base / name).parent for base in bases for name in names if "/" in name.rstrip("/")]
        missing = [name for name in names if not any((one / name).exists() for one in [*bases, *folders])]
        assert missing == [], text[:80]


@pytest.mark.parametrize("page", [README, CONTRIBUTING], ids=["README", "CONTRIBUTING"])
def test_links_lead_somewhere(page):
    targets = re.findall(r"\]\(([^)#:]+)(?:#[\w-]+)?\)", page)
    assert targets
    assert [target for target in targets if not (ROOT / target).exists()] == []


def test_on_pypi_no_link_of_the_readme_is_relative():
    """There are no files beside it there; the build replaces links by these rules."""
    page, rules = README, PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["substitutions"]
    for rule in rules:
        page = re.sub(rule["pattern"], rule["replacement"].replace("$HFPR_VERSION", fl.__version__), page)
    before, after = (re.findall(r"\]\(([^)]+)\)", text) for text in (README, page))
    source = PROJECT["project"]["urls"]["Source"]
    assert sum(link.startswith(f"{source}/blob/v{fl.__version__}/") for link in after) > 10
    for old, new in zip(before, after, strict=True):
        assert new.startswith(("https://", "#"))
        assert new.endswith(old)


def test_the_projects_address_is_in_one_file_and_one_everywhere():
    """Where it moves only pyproject.toml changes: a file of TOML cannot refer to itself."""
    urls, source = PROJECT["project"]["urls"], PROJECT["project"]["urls"]["Source"]
    assert all(url == source or url.startswith(f"{source}/") for url in urls.values())
    address = source.partition("://")[2].encode()
    texts = [*ROOT.glob("*.*"), *(ROOT / "frictionlab").rglob("*.*"), *(ROOT / "docs").rglob("*.*")]
    texts = [path for path in texts if path.suffix in (".py", ".pyi", ".md", ".toml", ".cff", ".js", ".css")]
    assert len(texts) > 200
    assert [path.name for path in texts if address in path.read_bytes()] == ["pyproject.toml"]


@pytest.mark.slow
def test_python_of_the_readme_leaves_a_picture(tmp_path, monkeypatch):
    (lines,) = readme_blocks("python")
    monkeypatch.chdir(tmp_path)
    exec(lines, {})
    (picture,) = tmp_path.glob("*.png")
    with Image.open(picture) as image:
        assert min(image.size) > 300
        assert len(image.convert("RGB").getcolors(1_000_000)) > 50  # something is drawn


@pytest.mark.slow
def test_python_of_the_first_steps_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # it saves pictures
    exec("\n".join(blocks(STARTING, "python")), {})
    pyplot.close("all")


def test_version_is_the_same_everywhere():
    assert re.fullmatch(r"\d+\.\d+\.\d+", fl.__version__)
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f'\nversion: "{fl.__version__}"\n' in citation
    assert f"\n## [{fl.__version__}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def imported_packages(folder: Path) -> set[str]:
    """Packages of others that modules of a folder import, at the top or in functions."""
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in folder.rglob("*.py")]
    names = set()
    for node in [node for tree in trees for node in ast.walk(tree)]:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(str(node.module))
    known = {*sys.stdlib_module_names, "annotationlib", "frictionlab"}  # the second is Python's from 3.14 on
    return {name.partition(".")[0] for name in names} - known


@pytest.mark.slow
def test_every_package_that_is_imported_is_declared():
    project = PROJECT["project"]
    extras = project["optional-dependencies"]
    build = PROJECT["build-system"]["requires"]  # of the step that compiles the kernels
    asked = [
        *project["dependencies"],
        *extras["compile"],
        *extras["data"],
        *extras["lab"],
        *build,
    ]
    declared = {re.split(r"[^\w-]", line)[0] for line in asked}
    imported = {DISTRIBUTIONS.get(name, name) for name in imported_packages(ROOT / "frictionlab")}
    assert "numpy" in imported
    assert imported <= declared


@pytest.mark.slow
def test_no_import_goes_in_circles():
    graph = layout.imports()
    assert "frictionlab.hybrid.solve" in graph["frictionlab.analysis.simulate"]
    assert layout.cycles(graph) == []
    assert layout.cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [["b", "c"]]


@pytest.mark.slow
def test_no_text_is_run_as_python():
    """sympy does so: texts of users go to the parser of `read_expression`, and expressions are no texts."""
    sources = {path: path.read_text(encoding="utf-8") for path in (ROOT / "frictionlab").rglob("*.py")}
    calls = [
        (path.name, node)
        for path, source in sources.items()
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
    ]
    named = [(name, ast.unparse(node.func).rpartition(".")[2], ast.unparse(node)) for name, node in calls]
    parsers = [(name, text) for name, function, text in named if function in ("sympify", "S", "parse_expr")]
    assert len(parsers) > 10
    assert [(name, text) for name, text in parsers if not text.endswith(", strict=True)")] == []
    runs = {(name, function) for name, function, _ in named if function in ("eval", "exec")}
    # A law's own repr in its check; the annotations of a model's class, which are its author's code; the call
    # of a kernel with the names of its own arguments, where kernels are compiled ahead of time.
    assert runs == {("testing.py", "eval"), ("composition.py", "eval"), ("flat_functions.py", "exec")}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_notebook_is_committed_without_outputs(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert [cell["source"] for cell in code if cell["outputs"] or cell["execution_count"] is not None] == []
