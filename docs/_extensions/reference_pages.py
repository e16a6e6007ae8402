"""The reference: every public name of the package, grouped by the package it lives in.

The names are those of ``frictionlab.__all__``, so that a new one is on the site without further ado;
only a new package has to be given a title here.
"""

import re
from importlib import import_module
from importlib.util import find_spec
from inspect import ismodule

from borrowed_pages import DOCS, write
from sphinx.ext import autosummary
from sphinx.util.nodes import make_refnode

import frictionlab

GROUPS = {
    "models": ("Models", "A model is a frozen composition of parameters and components."),
    "components": (
        "Laws and other components",
        "What a model is composed of. A class of your own beside these is used like them, see "
        "[a law of your own](../how-to/own-law.md).",
    ),
    "automaton": (
        "Hybrid automata",
        "Modes, events and resets as plain data: what models are turned into, and what anybody may write, "
        "see [an automaton of your own](../how-to/own-automaton.md).",
    ),
    "hybrid": ("Solver", "Methods, runs, and the derivative of a run."),
    "stability": ("Stability of steady sliding", "Equilibria, eigenvalues and how parameters change them."),
    "structures": (
        "Structures from matrices",
        "Sparse matrices as finite-element programs export them, see [how](../how-to/structures.md).",
    ),
    "analysis": ("Runs and their analysis", "From one run to steady states, sweeps and periodic orbits."),
    "interruption": (
        "Ctrl-C and progress bars",
        "Every computation raises KeyboardInterrupt, and what it had computed is kept, see "
        "[stop it](../how-to/sweeps.md#stop-it). Bars are shown after a second, or not at all.",
    ),
    "plotting": (
        "Figures",
        "All of them take `ax=` and return artists. Those not in `frictionlab` itself are in "
        "`frictionlab.plotting`.",
    ),
    "widgets": ("Explorers", "For notebooks and, by `frictionlab app`, the browser."),
    "pages": ("Exported pages", "Files with the exact solver for any browser, see [how](../how-to/page.md)."),
    "paper": ("The paper", "Figures and claims of the paper, computed again."),
    "testing": ("Testing", "What a law or a model of your own has to pass."),
}
BACK = re.compile(r'(class="viewcode-back" href="[^"#]*)#[^"]*"')
HEAD = "# Reference\n\nEvery public name. Units are SI, angles in radians.\n"
NAMES = """
```{{eval-rst}}
.. autosummary::
{options}   :nosignatures:

{names}
```
"""
CONTENTS = "\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"


def names_of(package: str) -> list[str]:
    """Public names that live in a package, the way one writes them after ``frictionlab.``."""
    names = [name for name, home in frictionlab._HOME.items() if home.partition(".")[0] == package]
    module = import_module(f"frictionlab.{package}") if find_spec(f"frictionlab.{package}") else None
    own = [name for name in getattr(module, "__all__", ()) if name not in frictionlab._HOME]
    paths = map(path_of, names)
    return sorted([*paths, *(f"{package}.{name}" for name in own)], key=by_name)


def path_of(name: str) -> str:
    """A name as one writes it after ``frictionlab.``, but a module by where it is."""
    value = getattr(frictionlab, name)
    return value.__name__.removeprefix("frictionlab.") if ismodule(value) else name


def by_name(path: str) -> tuple[bool, str]:
    """Classes first, then functions, each by their letters."""
    name = path.rpartition(".")[2]
    return name[0].islower(), name.lower()


def make_pages(app, config) -> None:
    """A page for each group, with those of its names below it; an index of all names."""
    homes = {home.partition(".")[0] for home in frictionlab._HOME.values()} - {"", "_version"}
    unknown = homes - set(GROUPS)
    if unknown:
        raise ValueError(f"the package {unknown.pop()!r} has no title: add it to GROUPS in {__file__}")
    text, pages = HEAD, []
    for package, (title, about) in GROUPS.items():
        names = "\n".join(f"   ~frictionlab.{name}" for name in names_of(package))
        if names:
            text += f"\n## [{title}]({package}.md)\n\n{about}\n" + NAMES.format(options="", names=names)
            page = NAMES.format(options="   :toctree: generated\n", names=names)
            write(DOCS / "reference" / f"{package}.md", f"# {title}\n\n{about}\n{page}")
            pages.append(package)
    write(DOCS / "reference" / "index.md", text + CONTENTS.format(pages="\n".join(pages)))


def find_by_last_names(app, env, node, contnode):
    """Where a reference leads that leaves out the module, as ``:meth:`Trajectory.save```, or has another.

    Where several could be meant (a subclass's ``force``) the name stays without a link; only a name that
    leads nowhere is told.
    """
    if node.get("refdomain") != "py":
        return None
    domain, target = env.get_domain("py"), node["reftarget"].removeprefix("fl.")
    if target.startswith("frictionlab."):  # where it is defined; its page may be named by where it is public
        target = target.rpartition(".")[2]
    matching = [name for name in domain.objects if f".{name}".endswith(f".{target}")]
    if len(matching) == 1:
        entry = domain.objects[matching[0]]
        return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, contnode, matching[0])
    return contnode if matching else None


def keep_bars(app, what, name, obj, options, lines: list[str]) -> None:
    """Bars in docstrings are absolute values, as in |x|, and not reStructuredText's substitutions."""
    example = False
    for i, line in enumerate(lines):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        if not example:
            lines[i] = line.replace("|", r"\|")


def back_to_page(app, pagename, templatename, context, doctree) -> None:
    """From source code back to the top of a name's page: Sphinx takes names re-exported for others."""
    if pagename.startswith("_modules/"):
        context["body"] = BACK.sub(r'\1"', context["body"])


def setup(app):
    autosummary.WELL_KNOWN_ABBREVIATIONS += ("Eq.", "Eqs.", "Fig.", "Figs.")  # do not end a summary
    # Before Sphinx looks for pages, and autosummary in them for names.
    app.connect("config-inited", make_pages)
    app.connect("autodoc-process-docstring", keep_bars, priority=400)  # before numpydoc
    app.connect("html-page-context", back_to_page)
    app.connect("missing-reference", find_by_last_names)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
