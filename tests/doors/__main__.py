"""Compare random mechanisms and automata of users with the reference, and with themselves in other words.

python -m tests.doors --count 2000 --seed 1 [--further] [--words] [--automata] [--jobs 2]
"""

from __future__ import annotations

import argparse
from collections import Counter
from functools import partial
from multiprocessing import Pool

from tqdm import tqdm

from tests.doors import automata
from tests.doors.further import generate_further
from tests.doors.generate import generate
from tests.doors.judge import AGREES, LONG, judge
from tests.doors.metamorphic import OTHER_WORDS, applies, complaint

# How many times longer than compared a run is, and its tolerance.
EXTRAS = ((1.0, 1e-15), (1.0, 1e-12), (3.0, 1e-15), (10.0, 1e-9))
Found = list[tuple[str, str]]  # what is counted, and words where something differs


def main() -> None:
    """Judge the cases asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.doors", description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--further", action="store_true", help="mechanisms with further states")
    parser.add_argument("--words", action="store_true", help="compare with the same in other words")
    parser.add_argument("--automata", action="store_true", help="automata in place of mechanisms")
    options = parser.parse_args()
    door = of_automaton if options.automata else in_other_words if options.words else of_mechanism
    numbers = range(options.first, options.first + options.count)
    count: Counter[str] = Counter()
    with Pool(options.jobs) as pool:
        judged = pool.imap(partial(door, options), numbers)
        for number, found in zip(numbers, tqdm(judged, total=len(numbers), unit="case"), strict=True):
            for kind, words in found:
                count[kind] += 1
                if words:
                    tqdm.write(f"{number}: {kind}, {words[:300]}")
    print(dict(count))


def of_mechanism(options: argparse.Namespace, number: int) -> Found:
    """Compare the run of a mechanism with the reference."""
    one = (generate_further if options.further else generate)(options.seed, number)
    verdict = judge(one, LONG * one.period, *EXTRAS[number % len(EXTRAS)])
    return [(verdict.kind, "" if verdict.kind == AGREES else verdict.words or "nothing is foretold")]


def of_automaton(options: argparse.Namespace, number: int) -> Found:
    """Compare the run of an automaton with the reference."""
    words = automata.judge(automata.generate(options.seed, number), *EXTRAS[number % len(EXTRAS)])
    return [("undecided" if words.startswith("undecided") else "differs" if words else AGREES, words)]


def in_other_words(options: argparse.Namespace, number: int) -> Found:
    """Compare the run of a mechanism with the same in other words."""
    make, found = generate_further if options.further else generate, []
    one = make(options.seed, number)
    for name in filter(lambda name: applies(name, one), OTHER_WORDS):
        words = complaint(name, options.seed, number, LONG / 2 * one.period, make)
        found.append((f"{name}: {'differs' if words else 'same'}", words))
    return found


if __name__ == "__main__":
    main()
