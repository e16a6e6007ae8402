"""Claims as a table of one-line rows and folded blocks: nothing is lost, and what is always seen is short."""

from frictionlab.paper.report import claim_blocks, claim_summary
from frictionlab.paper.results import Claim, Claims, Verdict

LONG = "the motion is periodic for 0.9 <= mu_k < 1.8 & non-periodic for all other values " * 4
TABLE = Claims(
    (
        Claim("C1", "Fig. 1", "short", "0.1", Verdict.REPRODUCED),
        Claim("C2", "Fig. 2", LONG, "0.2", Verdict.IN_PART, "note 2", "full 2", "paper 2"),
        Claim("C3", "Figs 2, 13a, b", "other", "0.3", Verdict.REPRODUCED, "note 3"),
    )
)


def test_every_cell_is_in_the_block_of_its_claim():
    blocks = claim_blocks(TABLE).split("</details>")[:-1]
    assert len(blocks) == len(TABLE)
    for row, block in zip(TABLE, blocks, strict=True):
        assert f'id="claim-{row.id.lower()}"' in block
        inside = block.partition("</summary>")[2]
        given = [row.says, row.computed, row.full_gap_rate, row.paper_algorithm, row.note]
        assert all(cell in inside for cell in given)
        assert inside.count("\n* **") == sum(map(bool, given))


def test_the_table_has_a_line_and_the_pictures_of_each_claim():
    count, _, _, _, *rows = claim_summary(TABLE).splitlines()
    assert count == "3 claims: reproduced 2, reproduced in part 1."
    assert [row.split("|")[2].strip() for row in rows] == [
        "✔ reproduced",
        "◐ reproduced in part",
        "✔ reproduced",
    ]
    assert [row.count("![fig") for row in rows] == [0, 1, 2]  # there is no computed Fig. 1
    assert all(len(row.split("|")[3]) < 120 for row in rows)
