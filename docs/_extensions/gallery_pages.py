"""The gallery: each script in docs/gallery is run, and gets a page with its text, its picture and its code.

A script starts with a docstring, whose first line is the title, and leaves its picture in the variable
`figure`. tests/slow/docs/test_gallery.py runs the same scripts.
"""

import ast
import runpy
from pathlib import Path

from borrowed_pages import write
from sphinx.util import logging
from sphinx.util.display import status_iterator

FOLDER = Path(__file__).parents[1] / "gallery"
SOURCES = list((FOLDER.parents[1] / "frictionlab").rglob("*.py"))
HEAD = """# Gallery

Classic pictures of friction-induced vibration. Behind each is the short script that draws it,
complete as it is; the scripts are in `docs/gallery/`, and run as tests.

"""
CARD = """```{{figure}} pictures/{stem}.png
:alt: {title}
:target: {stem}.html
:figclass: card-of-gallery

[{title}]({stem}.md)
```
"""
PAGE = """# {title}

{text}

![{title}](pictures/{stem}.png)

```python
{code}
```
"""
CONTENTS = "```{{toctree}}\n:hidden:\n\n{names}\n```\n"


def make_pages(app, config) -> None:
    """Draw the pictures and write the pages."""
    scripts = sorted(FOLDER.glob("*.py"))
    cards = []
    for path in status_iterator(scripts, "gallery... ", length=len(scripts), stringify_func=lambda p: p.stem):
        about = {"stem": path.stem, **parts(path)}
        draw(path)
        write(FOLDER / f"{path.stem}.md", PAGE.format(**about))
        cards.append(CARD.format(**about))
    names = "\n".join(path.stem for path in scripts)
    write(FOLDER / "index.md", HEAD + "\n".join(cards) + CONTENTS.format(names=names))


def parts(path: Path) -> dict[str, str]:
    """Title, text and code of a script."""
    source = path.read_text(encoding="utf-8")
    docstring = ast.parse(source).body[0]
    title, _, text = ast.literal_eval(docstring.value).partition("\n")
    code = "\n".join(source.splitlines()[docstring.end_lineno :])
    return {"title": title.rstrip("."), "text": text.strip(), "code": code.strip()}


def draw(path: Path) -> None:
    """Run a script, unless its picture is newer than it and the package; what it raises fails the build."""
    picture = FOLDER / "pictures" / f"{path.stem}.png"
    picture.parent.mkdir(exist_ok=True)
    if picture.exists() and picture.stat().st_mtime > max(f.stat().st_mtime for f in (path, *SOURCES)):
        return
    try:
        runpy.run_path(str(path))["figure"].savefig(picture, dpi=200)
    except Exception as error:
        logging.getLogger(__name__).warning("%s: %r", path.name, error, location=str(path))


def setup(app):
    app.connect("config-inited", make_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
