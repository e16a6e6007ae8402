"""Claims as folded blocks: nothing of the table is lost, and what is always seen is short."""

from frictionlab.paper.report import claim_blocks
from frictionlab.paper.results import Claim, Claims, Verdict

LONG = "the motion is periodic for 0.9 <= mu_k < 1.8 & non-periodic for all other values " * 4
TABLE = Claims(
    (
        Claim("C1", "Fig. 1", "short", "0.1", Verdict.REPRODUCED),
        Claim("C2", "Fig. 2", LONG, "0.2", Verdict.IN_PART, "note 2", "full 2", "paper 2"),
        Claim("C3", "4.2", "other", "0.3", Verdict.REPRODUCED, "note 3"),
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
