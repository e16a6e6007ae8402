"""Exported pages within those of the site: the directive `live-page`.

    ```{live-page}
    :model: SliderOnBelt(mu_k=1.4)
    :picture: images/first-run.png

    What the picture shows.
    ```

exports that model while the site is built, and embeds the page. Where the solver has not been compiled for
browsers the picture stands there, or without one the text, and the build says so in a line, which is no
warning.
"""

import ast
import re
import shutil
from functools import cache
from pathlib import Path
from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

import frictionlab
from frictionlab.compilation.manifest import FILE, FOLDERS, objects_folder
from frictionlab.pages.export import SolverNotBuiltError

FOLDER = "live"  # in the site
SAYS = "exact solver, in your browser"
PACKAGE = Path(frictionlab.__file__).parent
SOURCES = [path for path in PACKAGE.rglob("*") if path.suffix in (".py", ".js", ".wasm", ".css", ".html")]
logger = logging.getLogger(__name__)


class LivePage(SphinxDirective):
    """One exported model."""

    has_content = True
    option_spec: ClassVar = {
        "model": directives.unchanged_required,  # such as SliderOnBelt(mu_k=1.4, friction=Stribeck(v_s=0.1))
        "set": directives.unchanged,  # what the page begins with, as in its links: x0=near&t_end=5
        "picture": directives.path,  # where there is no solver
        "height": directives.nonnegative_int,
    }

    def run(self) -> list[nodes.Node]:
        """The embedded page, or the picture."""
        text = self.options["model"]
        name = re.sub(r"[^A-Za-z0-9_.]+", "-", text).strip("-") + ".html"
        manifests = [objects_folder(folder) / FILE for folder in FOLDERS]
        # Read again when the solver is compiled, or changes.
        for source in (*filter(Path.is_file, manifests), *SOURCES):
            self.env.note_dependency(str(source))
        try:
            export(text, Path(self.env.doctreedir) / FOLDER / name)
        except SolverNotBuiltError as error:
            say_not_built(str(error))
            return self.picture()
        return [nodes.raw("", self.frame(name, text), format="html")]

    def frame(self, name: str, text: str) -> str:
        """The page in a frame that is loaded when it comes into view, and under it a line with links."""
        up = "../" * self.env.docname.count("/")
        place, setting = f"{up}{FOLDER}/{name}", self.options.get("set", "")
        link = f"{place}#{setting}" if setting else place
        height = self.options.get("height", 640)
        return (
            f'<figure class="live-page"><iframe src="{link}" title="{text.split("(")[0]}: {SAYS}" '
            f'loading="lazy" height="{height}" allow="fullscreen; clipboard-write"></iframe>'
            f"<figcaption>{SAYS}: take a body, and let it go elsewhere · "
            f'<a href="{link}" target="_blank">in a window of its own</a> · '
            f'<a href="{place}" download="{name}">download</a>: one file, no network</figcaption></figure>'
        )

    def picture(self) -> list[nodes.Node]:
        """The picture, with the content as its description; without a picture the content."""
        if "picture" not in self.options:
            return self.parse_content_to_nodes()
        return [nodes.image(uri=self.options["picture"], alt=" ".join(self.content))]


@cache
def say_not_built(why: str) -> None:
    """Once a build."""
    logger.info("live pages are left out: %s", why)


def export(text: str, path: Path) -> None:
    """Write the page of a model, unless it is there from these sources."""
    if path.exists() and path.stat().st_mtime > max(source.stat().st_mtime for source in SOURCES):
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    frictionlab.export_page(model_of(ast.parse(text, mode="eval").body), path)


def model_of(node: ast.expr):
    """A model or a law: a public name, called with numbers, texts and laws by name."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.args:
        given = {each.arg: model_of(each.value) for each in node.keywords}
        return getattr(frictionlab, node.func.id)(**given)
    return ast.literal_eval(node)


def copy_pages(app, exception) -> None:
    """Bring the pages into the site."""
    made = Path(app.doctreedir) / FOLDER
    if exception is None and app.builder.format == "html" and any(made.glob("*.html")):
        shutil.copytree(made, Path(app.outdir) / FOLDER, dirs_exist_ok=True)


def setup(app):
    app.add_directive("live-page", LivePage)
    app.connect("build-finished", copy_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
