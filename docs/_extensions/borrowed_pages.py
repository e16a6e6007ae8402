"""Pages that are kept elsewhere in the repository: changelog, how to contribute, and the course.

They are copied next to the site's own before these are read. A notebook is taken from the folder that
the environment variable FRICTIONLAB_EXECUTED names, where the tests have left it executed
(tests/slow/docs/test_tutorials.py); where it is not there, or its cells have changed, it is executed while
the site is built.
"""

import json
import os
import re
import tomllib
from pathlib import Path
from urllib.parse import quote

from course_cells import fold_solutions, markdown, put_live_page
from docutils import nodes
from myst_nb.core.render import NbElementRenderer

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
PAGES = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
FILES = ("LICENSE", "CITATION.cff")
FOLDERS = {"tutorials/": "course/", "docs/": ""}
# Where a notebook can be run without installing anything; the project's address is that of pyproject.toml.
SOURCE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]["Source"]
REPOSITORY = SOURCE.partition("github.com/")[2]
BINDER = f"https://mybinder.org/v2/gh/{REPOSITORY}/main?labpath="
COLAB = f"https://colab.research.google.com/github/{REPOSITORY}/blob/main/"
LAUNCH = "[Binder]({binder}) · [Colab]({colab}) · {{download}}`Download </../{place}>`"
IN_COLAB = f'! pip install "frictionlab[lab] @ git+{SOURCE}" && frictionlab course .'
NOTE = "Interactive: open this notebook in Jupyter to use it."
STYLES = re.compile(r"<link[^>]*href=\"https?://[^>]*>")
LINK = re.compile(r"\]\((\.\./)?([\w/.-]+)(#[\w-]+)?\)")


def copy_pages(app, config) -> None:
    """Bring all of them to where they are read."""
    for source, target in PAGES.items():
        write(DOCS / target, (ROOT / source).read_text(encoding="utf-8"))
    notebooks = sorted(ROOT.glob("tutorials/*.ipynb"))
    for path in notebooks:
        write(DOCS / "course" / path.name, notebook(path, notebooks))
    for path in (ROOT / "tutorials").glob("diagrams*/*.*"):  # what notebooks draw
        target = DOCS / "course" / path.parent.name / path.name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(path.read_bytes())
    write(DOCS / "course" / "diagrams.py", (ROOT / "tutorials" / "diagrams.py").read_text(encoding="utf-8"))


def write(path: Path, text: str) -> None:
    """Write a file, unless it is the same already: what has not changed is not read again."""
    path.parent.mkdir(exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def notebook(path: Path, course: list[Path]) -> str:
    """A notebook of the course as text, with outputs if there are any; the first one lists the others."""
    content = json.loads(path.read_text(encoding="utf-8"))
    executed = executed_copy(path, content)
    if executed:
        content = executed
        content["metadata"]["mystnb"] = {"execution_mode": "off"}
    content["cells"] = fold_solutions(content["cells"])
    content["cells"].insert(1, markdown("launch", launch(path)))
    put_live_page(path.stem, content["cells"], f"*{NOTE}*")
    if path == course[0]:
        names = "\n".join(other.stem for other in course[1:])
        source = f"```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{names}\n```"
        content["cells"].append(markdown("contents", source))
    return json.dumps(content, ensure_ascii=False)


def launch(path: Path) -> str:
    """Links by which a notebook is run elsewhere, or downloaded."""
    place = path.relative_to(ROOT).as_posix()
    links = LAUNCH.format(binder=BINDER + quote(place, safe=""), colab=COLAB + place, place=place)
    return f"Run it: {links}\n\n:::{{dropdown}} In Colab, first\n```\n{IN_COLAB}\n```\n:::"


def executed_copy(path: Path, content: dict) -> dict | None:
    """The notebook as the tests have run it, if its cells are still the same."""
    copy = Path(os.environ.get("FRICTIONLAB_EXECUTED", "/nowhere")) / path.name
    if not copy.exists():
        return None
    executed = json.loads(copy.read_text(encoding="utf-8"))
    return executed if sources(executed) == sources(content) else None


def sources(content: dict) -> list[str]:
    return ["".join(cell["source"]) for cell in content["cells"]]


def follow_links(app, docname: str, source: list[str]) -> None:
    """Links between files of the repository become links between pages."""
    up = "../" * docname.count("/")
    source[0] = LINK.sub(lambda link: moved(link, up), source[0])


def moved(link: re.Match, up: str) -> str:
    """A link of the Markdown text, by the place where its target is on the site; `up` leads to the root."""
    target, anchor = link[2], link[3] or ""
    if target in PAGES:
        return f"]({up}{PAGES[target]}{anchor})"
    if target == "README.md":
        return f"]({up}getting-started.md{anchor})"
    if target in FILES:
        return f"]({up}../{target})"
    if target.startswith(".github/"):  # of the repository alone, no pages
        return f"]({SOURCE}/blob/main/{target})"
    for folder, place in FOLDERS.items():
        if target.startswith(folder):
            return f"]({up}{place}{target.removeprefix(folder)}{anchor})"
    return link[0]


def say_interactive(renderer, data) -> list[nodes.Node]:
    """What stands in the place of a widget, which is nothing without a kernel."""
    return [nodes.paragraph("", "", nodes.emphasis(text=NOTE))]


def drop_remote_styles(app, pagename, templatename, context, doctree) -> None:
    """Films link the icons of their buttons from another server; the theme brings them along."""
    if "body" in context:
        context["body"] = STYLES.sub("", context["body"])


def setup(app):
    app.connect("config-inited", copy_pages)
    app.connect("source-read", follow_links)
    app.connect("html-page-context", drop_remote_styles)
    # myst-nb has no setting for this; else it writes megabytes of widget state into the pages.
    NbElementRenderer.render_widget_view = say_interactive
    NbElementRenderer.render_nb_finalise = lambda renderer, metadata: None
    return {"parallel_read_safe": True, "parallel_write_safe": True}
