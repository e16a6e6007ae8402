"""The claims of the paper on equilibria and linear stability, and the table of verdicts."""

import pytest

import frictionlab as fl
from frictionlab.paper.checks import linear_stability
from frictionlab.paper.report import claim_blocks, claim_summary
from frictionlab.paper.results import CLAIMS, Claim, Claims, Verdict, verdict_of_parts
from frictionlab.paper.scenes import agrees_with_printed
from tests.helpers.cases import slow_but

IN_PART = {"C2", "C6", "C7"}


@pytest.fixture(scope="module")
def table():
    return fl.paper.claims()


@pytest.mark.slow
def test_every_claim_registered_has_a_row_in_order(table):
    assert [row.id for row in table] == list(CLAIMS)
    assert set(CLAIMS) >= {f"C{i}" for i in range(1, 9)}
    assert all(row.where and row.says and row.computed for row in table)
    assert all(isinstance(row.verdict, Verdict) for row in table)


@pytest.mark.parametrize("name", slow_but(["C1", "C2", "C3", "C4", "C8"], [f"C{i}" for i in range(1, 9)]))
def test_verdicts(name):
    row = fl.paper.claims(name)[name]
    assert row.verdict is (Verdict.IN_PART if name in IN_PART else Verdict.REPRODUCED)
    assert bool(row.note) or name not in IN_PART


@pytest.mark.slow
def test_numbers_of_the_claims(table):
    assert "1.7983, 1.7972, 1.1484 at F = 100 N; 0.6389, 0.6099, 0.1352 at F = 1000 N" in table["C5"].computed
    for number in ("0.6897", "1.1943", "2.0890", "1.8717"):
        assert number in table["C8"].computed
    assert "11.9807 ± 102.615i" in table["C4"].computed


def test_some_claims_by_name():
    chosen = fl.paper.claims("C8", "C1")
    assert [row.id for row in chosen] == ["C8", "C1"]
    assert len(chosen) == 2
    with pytest.raises(KeyError, match="no claim 'C2' among C8, C1"):
        chosen["C2"]
    with pytest.raises(ValueError, match=r"must be one of C1, C2, .*got 'C99'"):
        fl.paper.claims("C1", "C99")


def test_a_wrong_number_is_found(monkeypatch):
    monkeypatch.setitem(linear_stability.EQUILIBRIA, "C1", (0.3, "-0.0043 -0.0305 -0.0037 -0.0062 -0.0002"))
    assert fl.paper.claims("C1")["C1"].verdict is Verdict.NOT_REPRODUCED
    monkeypatch.setitem(linear_stability.EIGENVALUES, 0.3, (("-0.05", "100"), ("-0.04", "89.5")))
    assert fl.paper.claims("C4")["C4"].verdict is Verdict.IN_PART


@pytest.mark.slow
def test_a_pair_that_does_not_couple_is_found():
    data = linear_stability.coalescence(100.0)
    assert linear_stability.modes_couple(data, 1e4)
    data.pairs[1e4] = (0, 4)
    assert not linear_stability.modes_couple(data, 1e4)


@pytest.mark.parametrize(
    ("value", "printed", "agreed"),
    [
        (-0.00525, "-0.0053", True),
        (-0.00524, "-0.0053", False),
        (0.0053, "-0.0053", False),
        (100.49, "100", True),
        (100.51, "100", False),
        (98.749, "98.7", True),
    ],
)
def test_a_value_agrees_where_it_rounds_to_what_is_printed(value, printed, agreed):
    assert agrees_with_printed(value, printed) is agreed


def test_verdict_of_parts():
    assert verdict_of_parts(True, True) is Verdict.REPRODUCED
    assert verdict_of_parts(True, False) is Verdict.IN_PART
    assert verdict_of_parts(False, False) is Verdict.NOT_REPRODUCED


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
