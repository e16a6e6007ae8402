"""Schematics of models: the directive `schematic`.

    ```{schematic} MassOnBelt()
    ```

draws the parts of a model as they are at the start of a run, as an SVG; those of one with contact forces half
a period later, with the forces that it has come to.  Its source stands below.
"""

import ast
import re
from pathlib import Path

import numpy as np
from docutils import nodes
from live_pages import SOURCES, model_of
from sphinx.util.docutils import SphinxDirective

import frictionlab
from frictionlab.plotting import RunFigure
from frictionlab.plotting.animation.animate import mechanism_of, picture_of

FOLDER = "schematics"  # beside the page
SIZE = (5.0, 3.2)  # inches
BODY = "#56B4E9"


class Schematic(SphinxDirective):
    """One model, as what it is made of."""

    has_content = False
    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """The picture, and the source of the model."""
        text = self.arguments[0]
        name = re.sub(r"[^A-Za-z0-9_.]+", "-", text).strip("-") + ".svg"
        page = Path(self.env.doc2path(self.env.docname)).parent
        draw(text, page / FOLDER / name)
        alt = f"The parts of {text.partition('(')[0]}: bodies, springs and the contact"
        image = nodes.image(uri=f"{FOLDER}/{name}", alt=alt, classes=["schematic"])
        self.set_source_info(image)
        source = model_of(ast.parse(text, mode="eval").body).reference
        return [image, nodes.caption("", source)] if source else [image]


def draw(text: str, path: Path) -> None:
    """Write the picture of a model, unless it is there from these sources."""
    if path.exists() and path.stat().st_mtime > max(source.stat().st_mtime for source in SOURCES):
        return
    path.parent.mkdir(exist_ok=True)
    model = model_of(ast.parse(text, mode="eval").body)
    run = frictionlab.simulate(model, 3.0 * model.period, progress=False)
    picture = picture_of(run, mechanism_of(run, "a schematic"), np.array([0.0, model.period / 2]))
    figure = RunFigure(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    handles = [*picture.handles()]
    picture.move(picture.draw(ax), 1 if handles else 0, BODY)
    ax.set_axis_off()
    for handle in handles:  # without how large they get in that run
        handle.set_label(handle.get_label().partition(",")[0])
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
    figure.savefig(path, bbox_inches="tight")


def setup(app):
    app.add_directive("schematic", Schematic)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
