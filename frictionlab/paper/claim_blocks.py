"""Checked claims as a page shows them: a summary that fits a screen, and a block for each that opens."""

from __future__ import annotations

from html import escape

from frictionlab.paper.checks.claim import Claim, Claims, Verdict

SIGNS = {
    Verdict.REPRODUCED: "✔",
    Verdict.IN_PART: "◐",
    Verdict.BY_PAPER: "△",
    Verdict.NOT_REPRODUCED: "✘",
}
BLOCK = """\
<details class="claim" id="claim-{name}">
<summary><b>{id}</b> <span class="verdict verdict-{kind}">{sign} {verdict}</span> {where}: {short}</summary>

{rows}

</details>
"""
LONGEST_SUMMARY = 90  # characters of what the paper says, in the line that is always seen


def claim_summary(table: Claims) -> str:
    """How many claims have each verdict, and which, one line each."""
    counts = {verdict: [row.id for row in table if row.verdict == verdict] for verdict in Verdict}
    words = ", ".join(f"{verdict} {len(names)}" for verdict, names in counts.items() if names)
    lines = [
        f"* {SIGNS[verdict]} **{verdict}**: {', '.join(map(_link, names))}"
        for verdict, names in counts.items()
        if names
    ]
    return "\n".join([f"{len(table)} claims: {words}.", "", *lines])


def claim_blocks(table: Claims) -> str:
    """One folded block for each claim: the verdict outside, all numbers inside."""
    return "\n".join(map(_block, table))


def _link(name: str) -> str:
    return f'<a href="#claim-{name.lower()}">{name}</a>'


def _block(row: Claim) -> str:
    return BLOCK.format(
        name=row.id.lower(),
        id=row.id,
        kind=row.verdict.name.lower().replace("_", "-"),
        sign=SIGNS[row.verdict],
        verdict=row.verdict,
        where=escape(row.where),
        short=escape(_shortened(row.says)),
        rows="\n".join(f"* **{head}**: {text}" for head, text in _rows(row) if text),
    )


def _rows(row: Claim) -> tuple[tuple[str, str], ...]:
    return (
        ("the paper says", row.says),
        ("computed, exact solver", row.computed),
        ("with the full gap rate", row.full_gap_rate),
        ("by the paper's algorithm", row.paper_algorithm),
        ("why", row.note),
    )


def _shortened(text: str) -> str:
    if len(text) <= LONGEST_SUMMARY:
        return text
    return text[:LONGEST_SUMMARY].rpartition(" ")[0] + " …"
