"""Compare random mechanisms and automata of users with the reference, and with themselves in other words.

python -m tests.doors --count 2000 --seed 1 [--further] [--words] [--automata]
"""

from __future__ import annotations

import argparse
from collections import Counter

from tests.doors import automata
from tests.doors.further import generate_further
from tests.doors.generate import generate
from tests.doors.judge import AGREES, LONG, judge
from tests.doors.metamorphic import OTHER_WORDS, applies, complaint

# How many times longer than compared a run is, and its tolerance.
EXTRAS = ((1.0, 1e-15), (1.0, 1e-12), (3.0, 1e-15), (10.0, 1e-9))


def main() -> None:
    """Judge the cases asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.doors", description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--further", action="store_true", help="mechanisms with further states")
    parser.add_argument("--words", action="store_true", help="compare with the same in other words")
    parser.add_argument("--automata", action="store_true", help="automata in place of mechanisms")
    options = parser.parse_args()
    if options.automata:
        of_automata(options)
        return
    if options.words:
        in_other_words(options)
        return
    make = generate_further if options.further else generate
    count: Counter[str] = Counter()
    for number in range(options.first, options.first + options.count):
        one = make(options.seed, number)
        verdict = judge(one, LONG * one.period, *EXTRAS[number % len(EXTRAS)])
        count[verdict.kind] += 1
        if verdict.kind != AGREES:
            print(f"{number}: {verdict.kind}, {verdict.words[:300]}", flush=True)
    print(dict(count))


def of_automata(options: argparse.Namespace) -> None:
    """Compare runs of automata with the reference."""
    count: Counter[str] = Counter()
    for number in range(options.first, options.first + options.count):
        words = automata.judge(automata.generate(options.seed, number), *EXTRAS[number % len(EXTRAS)])
        count["undecided" if words.startswith("undecided") else "differs" if words else AGREES] += 1
        if words:
            print(f"{number}: {words}", flush=True)
    print(dict(count))


def in_other_words(options: argparse.Namespace) -> None:
    """Compare runs with the same in other words."""
    make = generate_further if options.further else generate
    count: Counter[str] = Counter()
    for number in range(options.first, options.first + options.count):
        one = make(options.seed, number)
        for name in OTHER_WORDS:
            if applies(name, one):
                words = complaint(name, options.seed, number, LONG / 2 * one.period, make)
                count[f"{name}: {'differs' if words else 'same'}"] += 1
                if words:
                    print(f"{number}, {name}: {words}", flush=True)
    print(dict(count))


if __name__ == "__main__":
    main()
