"""What hatchling calls when a wheel is made, also by ``pip install .`` and ``pip install -e .``.

A clone has the kernels as machine code for every target.  As long as they fit the sources there is nothing to
do, and nothing but hatchling is needed.  After an edit of a kernel this hook asks for numba and compiles for
the machine at hand, in a separate process.  Where it cannot, or the variable ``FRICTIONLAB_BUILD_KERNELS`` is
0 or empty, the package is installed nevertheless: kernels are then compiled by numba when they are used,
where it is installed, else they run as plain Python.

With the variable ``FRICTIONLAB_BUILD_STRUCTURES=1``, for a wheel that is published, the hook derives the
structures of the library's models too.  Else they are derived when they are first used.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNELS, STRUCTURES = "FRICTIONLAB_BUILD_KERNELS", "FRICTIONLAB_BUILD_STRUCTURES"
COMPILE = "-m", "frictionlab.compilation", "--if-changed"
DERIVE = "-m", "frictionlab.cli.shipped_structures"
# The one place where numba is pinned: what it makes is what users run.
NEEDED_TO_COMPILE = ("numba==0.68.*; python_version < '3.15'", "numpy>=2.0", "sympy>=1.14")
NEEDED_TO_DERIVE = ("llvmlite>=0.43", "numpy>=2.0", "scipy>=1.15", "sympy>=1.14")
OBJECTS = "frictionlab/compilation/objects_of_machine"
# Not written into the package: in a clone, whose sources change, structures are derived.
ARCHIVE, ARCHIVE_IN_WHEEL = "build/structures.zip", "frictionlab/models/structures.zip"
SLOW = "kernels will be compiled by numba when they are used, or run as plain Python"


class KernelBuildHook(BuildHookInterface):
    """The build step of hatchling, by the name that its option `path` asks for."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """Packages that this build needs beside hatchling."""
        compiler = NEEDED_TO_COMPILE if self._must_compile() and self._platform() else ()
        return [*compiler, *(NEEDED_TO_DERIVE if _is_set(STRUCTURES, "0") else ())]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before the files of a wheel are chosen; `version` is "standard" or "editable"."""
        if self._must_compile():
            self._compile()
        if self._has_objects_of_machine():
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{self._platform()}"
            build_data["artifacts"].append(f"/{OBJECTS}/")
        if version == "standard":
            build_data["force_include"].update(self._manifest())
        path = os.path.join(self.root, ARCHIVE)
        fails = "the models' equations will be derived when they are first used"
        if _is_set(STRUCTURES, "0") and self._has_run((*DERIVE, path), fails):
            build_data["force_include"][path] = ARCHIVE_IN_WHEEL

    def _must_compile(self) -> bool:
        """Whether there are no objects of the present sources for this system."""
        return _is_set(KERNELS, "1") and isinstance(self._compiled(), str)

    def _has_objects_of_machine(self) -> bool:
        """Whether those of the repository do not fit the sources, but those compiled on this machine do."""
        compiled = self._compiled()
        return not isinstance(compiled, str) and compiled.folder != self._modules()[0].REPOSITORY

    def _compiled(self) -> Any:
        manifest, targets = self._modules()
        return manifest.compiled_object([target.file for target in targets.targets_of_system()])

    def _manifest(self) -> dict[str, str]:
        """The manifest of the repository's objects, and its place in a wheel.

        Where prose has changed it is one of the present files.  pyproject.toml excludes the file from the
        package's, since hatchling takes no second one for a place.
        """
        manifest, _ = self._modules()
        place = f"frictionlab/compilation/{manifest.REPOSITORY}/{manifest.FILE}"
        current = manifest.read_manifest(manifest.objects_folder(manifest.REPOSITORY))
        if current is None or manifest.changed_sources(current) or manifest.refreshed(current) == current:
            path = os.path.join(self.root, *place.split("/"))
            return {path: place} if os.path.exists(path) else {}
        path = os.path.join(self.root, "build", manifest.FILE)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", newline="\n") as file:
            file.write(manifest.refreshed(current).to_json())
        return {path: place}

    def _compile(self) -> None:
        if not self._platform():
            self.app.display_warning(f"no compiler for this processor and system: {SLOW}")
            return
        self.app.display_info("frictionlab compiles its solver for this machine, a minute or two ...")
        self._has_run(COMPILE, f"the solver could not be compiled, {SLOW}")

    def _has_run(self, arguments: Sequence[str], otherwise: str) -> bool:
        """Run Python with these arguments; returns whether it succeeded, else a warning says what follows."""
        try:
            self._run(*arguments)
        except (OSError, subprocess.CalledProcessError) as error:
            (*_, last) = (getattr(error, "stderr", None) or str(error)).strip().splitlines()
            self.app.display_warning(f"{otherwise}: {last}")
            return False
        return True

    def _platform(self) -> str:
        """The platform tag of a wheel with objects of this machine; "" where there can be none."""
        if sys.platform == "linux" and platform.libc_ver()[0] != "glibc":  # llvmlite has no wheels there
            return ""
        _, targets = self._modules()
        return next((target.wheel for target in targets.targets_of_system()), "")

    def _modules(self) -> tuple[Any, Any]:
        """What reads manifests, and the list of targets: of the clone, which need Python only."""
        if sys.path[0] != self.root:
            sys.path.insert(0, self.root)
        from frictionlab.compilation import manifest, targets

        return manifest, targets

    def _run(self, *arguments: str) -> str:
        """Run Python in the clone; returns what it has printed."""
        # The clone comes before the path that pip has set for the packages that the build needs.
        path = os.pathsep.join(filter(None, (self.root, os.environ.get("PYTHONPATH"))))
        environment = {**os.environ, "PYTHONPATH": path}
        command = [sys.executable, *arguments]
        options = {"cwd": self.root, "capture_output": True, "text": True, "check": True}
        return subprocess.run(command, env=environment, **options).stdout


def _is_set(variable: str, default: str) -> bool:
    return os.environ.get(variable, default) not in ("", "0")
