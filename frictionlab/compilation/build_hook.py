"""What hatchling calls when a wheel is made: compile the kernels, derive the structures of the library's
models, have the wheel carry both.

The kernels are compiled in a separate process, for the machine at hand, unless the objects in the clone were
made from these very sources.  Where that fails, or the variable ``FRICTIONLAB_BUILD_KERNELS`` is 0 or empty,
the wheel holds Python only.  On the user's machine numba then compiles the kernels where it is installed,
else they run as plain Python; structures are derived there when they are needed.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "FRICTIONLAB_BUILD_KERNELS"
COMMAND = "-m", "frictionlab.compilation", "--if-changed"
OBJECTS = "frictionlab/compilation/objects"
DERIVE = "-m", "frictionlab.cli.shipped_structures"
# Not written into the package: in a clone, whose sources change, structures are derived.
STRUCTURES, STRUCTURES_IN_WHEEL = "build/structures.zip", "frictionlab/models/structures.zip"


class KernelBuildHook(BuildHookInterface):
    """The build step of hatchling, by the name that its option `path` asks for."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before the files of a wheel are chosen; `version` is "standard" or "editable"."""
        if os.environ.get(VARIABLE, "1") in ("", "0"):
            return
        self.app.display_info("frictionlab compiles its solver for this machine, a minute or two ...")
        fails = "the solver could not be compiled, it will run by numba or as plain Python"
        is_clone = version == "editable"  # which stays on this machine; a wheel may go to another
        if not self._has_run((*COMMAND, "--best") if is_clone else COMMAND, fails) or is_clone:
            return
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{self._platform()}"
        build_data["artifacts"].append(f"/{OBJECTS}/")
        path = os.path.join(self.root, STRUCTURES)
        if self._has_run((*DERIVE, path), "the models' equations will be derived when they are first used"):
            build_data["force_include"][path] = STRUCTURES_IN_WHEEL

    def _has_run(self, arguments: Sequence[str], otherwise: str) -> bool:
        """Run Python with these arguments; returns whether it succeeded, else a warning says what follows."""
        try:
            self._run(*arguments)
        except (OSError, subprocess.CalledProcessError) as error:
            said = getattr(error, "stderr", None) or str(error)
            self.app.display_warning(f"{otherwise}: {said[-2000:]}")
            return False
        return True

    def _platform(self) -> str:
        """The platform tag of a wheel for this machine."""
        if sys.platform == "linux" and platform.libc_ver()[0] != "glibc":
            return sysconfig.get_platform().replace("-", "_")
        sys.path.insert(0, self.root)
        from frictionlab.compilation.manifest import targets_of_machine

        return targets_of_machine()[0].wheel

    def _run(self, *arguments: str) -> str:
        """Run Python in the clone; returns what it has printed."""
        # The clone comes before the path that pip has set for the packages that the build needs.
        path = os.pathsep.join(filter(None, (self.root, os.environ.get("PYTHONPATH"))))
        environment = {**os.environ, "PYTHONPATH": path}
        command = [sys.executable, *arguments]
        options = {"cwd": self.root, "capture_output": True, "text": True, "check": True}
        return subprocess.run(command, env=environment, **options).stdout
