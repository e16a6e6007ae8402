"""`python -m frictionlab.compilation`: compile the kernels; see the package."""

import argparse
import os
import sys
from pathlib import Path

from frictionlab.compilation.manifest import MACHINE, REPOSITORY, lacking_objects, objects_folder
from frictionlab.compilation.targets import TARGETS, WEB, Target, targets_of_machine


def parsed() -> argparse.Namespace:
    """The arguments of the command."""
    parser = argparse.ArgumentParser(
        description="Compile the kernels ahead of time, for this machine or for all. This needs numba; for "
        "browsers also ziglang."
    )
    parser.add_argument(
        "--all",
        action="store_true",
        help="the objects of the repository: every processor, system and browser",
    )
    parser.add_argument(
        "--compare", action="store_true", help="compile those again, and tell which of them differ"
    )
    parser.add_argument("--web", action="store_true", help="for browsers too")
    parser.add_argument(
        "--target", choices=[target.name for target in TARGETS], help="for this processor and system only"
    )
    parser.add_argument("--if-changed", action="store_true", help="not where the objects fit the sources")
    return parser.parse_args()


def chosen_targets(arguments: argparse.Namespace) -> list[Target]:
    """What to compile for; by default the best that this processor can do."""
    if arguments.all:
        return [*TARGETS, WEB]
    if arguments.target:
        targets = [target for target in TARGETS if target.name == arguments.target]
    else:
        targets = targets_of_machine()[:1]
    return [*targets, WEB] if arguments.web else targets


def main() -> None:
    """Compile for the targets that the arguments name."""
    arguments = parsed()
    targets = chosen_targets(arguments)
    if not targets:
        sys.exit("kernels: there is no target for this processor and system; --help lists them")
    if arguments.if_changed and not lacking_objects(target.file for target in targets):
        print("kernels: compiled before, from these sources")
        return
    os.environ["FRICTIONLAB_COMPILE_KERNELS"] = "1"  # read when kernels are imported, as `build` does
    from frictionlab.compilation.build import build, differences

    if arguments.compare:
        different = differences(Path(str(objects_folder(REPOSITORY))), report)
        sys.exit(
            f"kernels: {', '.join(different)}: run python -m frictionlab.compilation --all"
            if different
            else 0
        )
    build(targets, Path(str(objects_folder(REPOSITORY if arguments.all else MACHINE))), report)


def report(text: str) -> None:
    print(text, flush=True)


if __name__ == "__main__":
    main()
