"""``python -m tests.digests [--write]``: compare all runs with the digests, or write these anew."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from tests.digests.runs import cases, digest_of

FILE = Path(__file__).with_name("digests.json")


def main() -> int:
    """Compare or write; the exit code is how many runs differ."""
    parser = argparse.ArgumentParser(prog="python -m tests.digests", description="The same bits everywhere.")
    parser.add_argument("--write", action="store_true", help="write the digests anew")
    write = parser.parse_args().write
    known = {} if write else json.loads(FILE.read_text(encoding="utf-8"))
    found, differ = {}, 0
    for case in cases():
        run = case.run()
        found[case.name] = {"events": len(run.events), "sha256": digest_of(run)}
        same = write or known.get(case.name) == found[case.name]
        differ += not same
        sizes = f"{len(run.events)} events, {len(run.raw.step_times)} steps"
        print(f"{'' if same else 'DIFFERS  '}{case.name}: {sizes}", flush=True)
    if write:
        FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(f"{differ} of {len(found)} runs differ")
    return min(differ, 100)


if __name__ == "__main__":
    sys.exit(main())
