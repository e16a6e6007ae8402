"""What the site makes of the course's cells: solutions that stay closed, pages to play with for explorers.

A notebook marks the cells of a solution by their names: `solution-3-text`, `solution-3`.  All of one
solution, its words, its code and what the code shows, goes into one block that opens on a click and needs no
script.
"""

import re

SOLUTION = re.compile(r"solution-(\d+)")
IN_WORDS = re.compile(r"\A<details>\s*<summary>.*?</summary>\s*(.*?)\s*</details>\s*\Z", re.DOTALL)
OPENING = '<details class="solution">\n<summary>Solution {number}</summary>'
CLOSING = "</details>"
# Explorers are nothing without a kernel.  In their place: the model as an exported page, which begins so.
FULL_GAP_RATE = 'SliderOnBelt(mu_k=1.4, impact=PlasticImpact(penetration_rate="full"))'
LIVE = {
    "00-one-mass": ("MassOnBelt()", "t_end=60"),
    "01-first-run": ("SliderOnBelt(mu_k=1.4)", "without=geometry&t_end=5"),
    "03-what-eigenvalues-tell": ("SliderOnBelt(mu_k=1.4)", "x0=near&t_end=5"),
    "05-ablation": (FULL_GAP_RATE, "t_end=5"),
    "06-trust-your-solver": ("SliderOnBelt(mu_k=1.4)", "t_end=2"),
    "08-limit-cycles": (FULL_GAP_RATE, "t_end=5"),
}
LIVE_PAGE = "```{{live-page}}\n:model: {model}\n:set: {setting}\n\n{note}\n```"


def fold_solutions(cells: list[dict]) -> list[dict]:
    """The cells, with each solution in a block of its own that is closed at first."""
    folded, opened = [], None
    for cell in cells:
        match = SOLUTION.match(cell["id"])
        number = match[1] if match else None
        if opened != number:
            if opened:
                folded.append(markdown(f"close-{opened}", CLOSING))
            if number:
                folded.append(markdown(f"open-{number}", OPENING.format(number=number)))
            opened = number
        folded.append(unfolded(cell) if number else cell)
    return folded + ([markdown(f"close-{opened}", CLOSING)] if opened else [])


def unfolded(cell: dict) -> dict:
    """A cell of a solution, as it is within its block: without a fold of its own."""
    inner = IN_WORDS.match("".join(cell["source"]))
    return cell | {"source": inner[1]} if inner else cell


def put_live_page(name: str, cells: list[dict], note: str) -> None:
    """Put an exported page where an explorer would be; without a solver the note stands there."""
    if name not in LIVE:
        return
    (place,) = [i for i, cell in enumerate(cells) if cell["id"] == "explore"]
    model, setting = LIVE[name]
    cells[place].setdefault("metadata", {}).setdefault("tags", []).append("remove-output")
    source = LIVE_PAGE.format(model=model, setting=setting, note=note)
    cells.insert(place + 1, markdown("live", source))


def markdown(name: str, source: str) -> dict:
    """A cell of text."""
    return {"cell_type": "markdown", "id": name, "metadata": {}, "source": source}
