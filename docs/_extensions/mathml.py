"""Equations as MathML, which browsers draw themselves: no script, and nothing from another server.

What the converter does not know is a warning with its place, and so an error of the build. The font,
STIX Two Math, comes with the package ziamath: without one that is made for mathematics browsers draw
equations badly.
"""

import re
from html import escape, unescape
from importlib.resources import files

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util import logging

logger = logging.getLogger(__name__)
TAG = re.compile(r"\\tag\{([^}]*)\}")  # the number that an equation has in the paper
DISPLAY = "\\displaystyle"
PUNCTUATED = re.compile(r'<span class="math">(?:(?!</span>).)*</span>[.,;:!?)]+', re.DOTALL)
CELL = re.compile(r"(<td[^>]*>)\$([^$<]+)\$(?=</td>)")
FAILED = re.compile(r"\\|<mi>&<")  # what is left of commands and environments that it does not know
REWRITTEN = {  # what the converter does not know, or would draw in italics
    re.compile(r"\{aligned\}"): "{split}",
    re.compile(r"\\mathrm\{(\w)\}"): r"{\\mathrm \1}",
    re.compile(r"\\mathbf (\w)"): r"\\mathbf{\1}",
    re.compile(r"([_^])(\\math\w+(?:\{[^{}]*\}| \w))"): r"\1{\2}",
}


def converted(node: nodes.Node, display: str) -> str:
    """MathML of a formula; its LaTeX where that fails."""
    tex = TAG.sub("", node.astext()).strip()
    if tex.startswith(DISPLAY):  # as what notebooks show does
        tex, display = tex.removeprefix(DISPLAY), "block"
    for pattern, replacement in REWRITTEN.items():
        tex = pattern.sub(replacement, tex)
    try:
        result = convert(tex, display=display)
    except Exception as error:
        result = f"\\ {error!r}"
    if not FAILED.search(result):
        return result
    logger.warning("no MathML of %r: %s", tex, result, location=node)
    return f"<code>{escape(tex)}</code>"


def inline(self, node: nodes.math) -> None:
    """A formula in a line of text."""
    self.body.append(f'<span class="math">{converted(node, "inline")}</span>')
    raise nodes.SkipNode


def displayed(self, node: nodes.math_block) -> None:
    """A formula on a line of its own, with its number in the paper where it has one."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    self.body.append(converted(node, "block"))
    for number in TAG.findall(node.astext()):
        self.body.append(f'<span class="eqno">({number})</span>')
    self.body.append("</div>\n")
    raise nodes.SkipNode


def in_tables(app, pagename, templatename, context, doctree) -> None:
    """Formulas in tables that were HTML already, such as those of ``model.describe()``."""
    if "body" in context:
        context["body"] = CELL.sub(
            lambda cell: cell[1] + converted(nodes.math(text=unescape(cell[2])), "inline"), context["body"]
        )


def keep_punctuation(app, pagename, templatename, context, doctree) -> None:
    """No line begins with the full stop or the comma that follows a formula."""
    if "body" in context:
        context["body"] = PUNCTUATED.sub(r'<span class="punctuated">\g<0></span>', context["body"])


def setup(app):
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.connect("html-page-context", in_tables)
    app.connect("html-page-context", keep_punctuation)
    app.connect(
        "config-inited", lambda app, config: config.html_static_path.append(str(files("ziamath") / "fonts"))
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
