"""`python -m frictionlab.compilation`: compile the kernels; see the package."""

import argparse
import os

from frictionlab.compilation.manifest import TARGETS, WEB, lacking_objects, targets_of_machine


def main() -> None:
    """Compile for the targets that the arguments name."""
    parser = argparse.ArgumentParser(description="Compile the kernels ahead of time; this needs numba.")
    parser.add_argument("--all", action="store_true", help="for every processor and system, and for browsers")
    parser.add_argument("--web", action="store_true", help="for browsers too (needs ziglang)")
    parser.add_argument(
        "--target", choices=[target.name for target in TARGETS], help="for this processor and system only"
    )
    parser.add_argument("--best", action="store_true", help="for the best that this processor can do only")
    parser.add_argument("--if-changed", action="store_true", help="not where the objects fit the sources")
    arguments = parser.parse_args()
    chosen = [*(TARGETS if arguments.all else targets_of_machine())]
    if arguments.best:
        chosen = chosen[:1]
    if arguments.target:
        chosen = [target for target in TARGETS if target.name == arguments.target]
    if arguments.web or arguments.all:
        chosen.append(WEB)
    if arguments.if_changed and not lacking_objects(target.file for target in chosen):
        print("kernels: compiled before, from these sources")
        return
    os.environ["FRICTIONLAB_COMPILE_KERNELS"] = "1"  # read when kernels are imported, as `build` does
    from frictionlab.compilation.build import build

    build(chosen, lambda text: print(text, flush=True))


if __name__ == "__main__":
    main()
