"""`python -m frictionlab`: the same as the command `frictionlab`."""

import sys

from frictionlab.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
