"""Standard streams that are closed, a full standard output, numba that cannot be loaded, a package in a zip
file: a process runs on, or ends with one line.
"""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
posix = pytest.mark.skipif(not Path("/dev/full").exists(), reason="a full device is Linux's")
RUN = "run --t-end 0.1"
LONG_RUN = "import frictionlab as fl; assert fl.simulate(fl.SliderOnBelt(mu_k=1.4), 60.0).status.ok"
SHORT_RUN = "import frictionlab as fl; print(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.02).status.name)"
FULL = (
    "frictionlab: error: standard output cannot be written ([Errno 28] No space left on device): "
    "send it elsewhere\n"
)


def ended(words, redirection="", path=ROOT, **variables):
    """Exit status, standard output and standard error of Python with its streams redirected by a shell."""
    environment = {**os.environ, "PYTHONPATH": str(path), "PYTHONUNBUFFERED": ""}
    environment |= {"PYTHONSAFEPATH": "1", **variables}  # no package from the working folder
    command = ["sh", "-c", f'exec "$@" {redirection}', "sh", sys.executable, *words]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=600)
    return done.returncode, done.stdout, done.stderr


def frictionlab(words, redirection="", **variables):
    return ended(["-m", "frictionlab", *words.split()], redirection, **variables)


@posix
@pytest.mark.parametrize("words", [RUN, "figure 2 -o fig2.png", "--help", "--version", ""])
def test_full_standard_output_is_told_in_one_line(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert frictionlab(words, ">/dev/full") == (1, "", FULL)


@posix
def test_without_standard_error_a_command_runs_on():
    status, out, _ = frictionlab(RUN, "2>&-")
    assert status == 0
    assert "Computed 0.1 s" in out
    assert frictionlab("runn", "2>&-")[0] == 2


@posix
@pytest.mark.parametrize("redirection", [">&-", ">&- 2>&-"])
def test_without_standard_output_a_command_runs_on(redirection, tmp_path):
    saved = tmp_path / "run.npz"
    status, _, err = frictionlab(f"{RUN} --save {saved}", redirection)
    assert (status, err) == (0, "")
    assert saved.exists()
    assert frictionlab("runn", redirection)[0] == 2


@posix
@pytest.mark.parametrize(
    "words", ["models", "models --json", "eig", "critical mu_k 0 4", "--help", "--version"]
)
def test_without_standard_output_every_command_ends_well(words):
    """As tools of Python do: `python -m json.tool --help >&-` ends with 0."""
    status, _, err = frictionlab(words, ">&-")
    assert status == 0
    assert "Traceback" not in err


@posix
def test_without_standard_error_a_run_has_no_bar():
    assert ended(["-c", f"{LONG_RUN}; print('ran')"], "2>&-")[:2] == (0, "ran\n")


def test_without_any_stream_as_under_pythonw():
    script = f"import sys; sys.stdout = sys.stderr = None\n{LONG_RUN}\n"
    script += "fl.sweep(fl.SliderOnBelt(), lambda m: m.F, {'F': [1.0, 2.0]})\n"
    script += "from frictionlab.cli.command import main\nassert main(['run', '--t-end', '0.1']) == 0\n"
    assert ended(["-c", script]) == (0, "", "")


def test_numba_without_compilation_is_no_numba():
    assert ended(["-c", SHORT_RUN], NUMBA_DISABLE_JIT="1") == (0, "FINISHED\n", "")


@pytest.mark.parametrize("error", ["OSError('no libllvmlite.so')", "ImportError('needs NumPy 2.4 or less')"])
def test_numba_that_cannot_be_imported_is_told(error, tmp_path):
    (tmp_path / "numba.py").write_text(f"raise {error}\n")
    variables = {"path": f"{tmp_path}{os.pathsep}{ROOT}", "FRICTIONLAB_COMPILE_KERNELS": "1"}
    status, out, err = ended(["-c", SHORT_RUN], **variables)
    assert (status, out) == (0, "FINISHED\n")
    assert "RuntimeWarning: numba cannot be imported" in err
    assert "install numba and llvmlite again" in err


def test_the_package_runs_from_a_zip_file(tmp_path):
    archive = tmp_path / "frictionlab.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for path in sorted((ROOT / "frictionlab").rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                file.write(path, path.relative_to(ROOT))
    cache = tmp_path / "cache"
    variables = {"path": archive, "FRICTIONLAB_DISABLE_NUMBA": "1", "FRICTIONLAB_CACHE_DIR": str(cache)}
    where = "import frictionlab; print(frictionlab.__file__); "
    status, out, err = ended(["-c", where + SHORT_RUN], **variables)
    assert (status, out) == (0, f"{archive}{os.sep}frictionlab{os.sep}__init__.py\nFINISHED\n"), err
    assert frictionlab("run --t-end 0.001", **variables)[0] == 0
    # Nothing tells the sources of one zip file from those of another, so what was derived is not kept.
    assert not [*cache.rglob("*.structure")]


def test_the_cache_of_a_zip_file_is_used_again(tmp_path):
    """By the digest of the sources in it, which the loader reads."""
    archive = tmp_path / "frictionlab.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for path in sorted((ROOT / "frictionlab").rglob("*.py*")):
            if path.suffix in (".py", ".pyi"):
                file.write(path, path.relative_to(ROOT))
    script = "from frictionlab.compilation import machine_code; print(machine_code.CACHE_FOLDER)"
    by_numba = {"FRICTIONLAB_COMPILE_KERNELS": "1"}  # the archive lacks the objects, whose digest is another
    inside, outside = (ended(["-c", script], path=path, **by_numba)[1] for path in (archive, ROOT))
    assert inside == outside != "\n"
