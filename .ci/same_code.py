#!/usr/bin/env python3
"""Whether the code is that of a commit.

`.ci/same_code.py COMMIT` ends with 0 if it is, with 1 if it may not be.  It is the same if between the two
nothing differs but Markdown, and comments and docstrings of Python files.
"""

import ast
import subprocess
import sys

HAVE_DOCSTRINGS = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef


def git(*arguments: str) -> str:
    """What git says; CalledProcessError where it fails."""
    return subprocess.run(("git", *arguments), check=True, capture_output=True, encoding="utf-8").stdout


def code(text: str) -> str:
    """A Python file without comments and docstrings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, HAVE_DOCSTRINGS) and ast.get_docstring(node, clean=False) is not None:
            node.body[0] = ast.Pass()
    return ast.dump(tree)


def is_same(commit: str, change: str) -> bool:
    """Whether a line of `git diff --name-status` changes no code."""
    kind, *names = change.split("\t")
    if all(name.endswith(".md") for name in names):
        return True
    if kind != "M" or not names[0].endswith(".py"):
        return False
    with open(names[0], encoding="utf-8") as file:
        return code(git("show", f"{commit}:{names[0]}")) == code(file.read())


def main() -> int:
    """The status of the process."""
    commit = sys.argv[1]
    try:
        if git("ls-files", "--others", "--exclude-standard"):
            return 1
        changes = git("diff", "--name-status", "--no-renames", commit, "--").splitlines()
        return 0 if all(is_same(commit, change) for change in changes) else 1
    except (subprocess.CalledProcessError, SyntaxError) as error:  # an unknown commit
        print(f"cannot compare with {commit}: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
