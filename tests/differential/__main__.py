"""Compare the solver with the reference on many random cases.

    python -m tests.differential --count 2000 --seed 1 [--model MassOnBelt] [--exact] [--keep]

Prints every failure as a line of code, then a table of what came out by model and kind.  --keep writes
failures to kept.txt, whose cases the suite runs from then on.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

from tqdm import tqdm

from tests.differential.generate import MAKERS, generate
from tests.differential.judge import judge

KEPT = Path(__file__).parent / "kept.txt"


def main() -> None:
    """Judge the cases asked for."""
    options = _options()
    count: Counter[tuple[str, str]] = Counter()
    numbers = range(options.first, options.first + options.count)
    for number in (bar := tqdm(numbers, dynamic_ncols=True)):
        case = generate(options.seed, number, options.model, options.exact)
        verdict = judge(case)
        count[type(case.model).__name__, verdict.kind] += 1
        bar.set_postfix(
            failed=sum(n for (_, kind), n in count.items() if kind not in ("agrees", "undecided"))
        )
        if verdict.failed:
            line = f"{case!r}  # seed {options.seed}, case {number}: {verdict.kind}, {verdict.words}"
            bar.write(line)
            if options.keep:
                with KEPT.open("a", encoding="utf-8") as file:
                    file.write(line + "\n")
    print(table(count))


def table(count: Counter[tuple[str, str]]) -> str:
    """Cases by model and verdict."""
    models, kinds = (sorted({key[i] for key in count}) for i in (0, 1))
    rows = [["", *kinds]] + [[m, *(str(count[m, kind]) for kind in kinds)] for m in models]
    rows.append(["all", *(str(sum(count[m, kind] for m in models)) for kind in kinds)])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in rows)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.differential",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=200, help="number of cases")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--model", choices=list(MAKERS), help="this model only")
    parser.add_argument("--exact", action="store_true", help="all at the default tolerance")
    parser.add_argument("--keep", action="store_true", help="add failures to kept.txt")
    return parser.parse_args()


if __name__ == "__main__":
    main()
