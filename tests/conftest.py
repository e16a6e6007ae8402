"""Settings of the whole test run; environment variables, so that subprocesses and notebooks have them too."""

import gc
import os
import shutil
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import settings

os.environ["MPLBACKEND"] = "Agg"
# As many processes run tests as there are cores; threads of BLAS beside them wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if os.environ.get("FRICTIONLAB_DISABLE_NUMBA", "0") not in ("", "0"):
    sys.modules["numba"] = None  # any import of it fails, as if it were not installed

# The first example may compile the solver, so no deadline; the same examples on every machine.
settings.register_profile("frictionlab", deadline=None, derandomize=True, max_examples=10)
settings.register_profile(
    "thorough", settings.get_profile("frictionlab"), max_examples=250
)  # in `nox -s slow`
settings.load_profile("frictionlab")

# A shell has commands that it starts in the background ignore ctrl-C; tests of it would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

pytest.register_assert_rewrite("tests.helpers", "tests.differential")  # helpers assert too


HERE = Path(__file__).parent

# By Python's own thresholds a twentieth of the processor time goes into looking, again and again, through
# what earlier tests have cached.  What counts for them is at the end: see `pytest_sessionfinish`.
gc.set_threshold(100_000, 20, 1000)


def pytest_ignore_collect(collection_path, config):
    """Folders that the default leaves out as a whole are not imported: that takes seconds in each process."""
    default = config.option.markexpr == "not slow and not browser"
    return (default and collection_path in (HERE / "slow", HERE / "browser")) or None


# Of two processes one reads the files from the last to the first: each writes the byte code of half of them,
# where there is none yet, and finds that of the other half.
BACKWARDS = os.environ.get("PYTEST_XDIST_WORKER", "gw0").endswith(tuple("13579"))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """The files of a folder, in the order in which this process reads them."""
    report = yield
    if BACKWARDS and isinstance(collector, pytest.Directory):
        report.result.reverse()
    return report


def pytest_collection_finish():
    """What has been imported lives to the end, so no collection of garbage need look through it again."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish():
    """As much for what tests have cached: pytest goes through all of it ten times at its end."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Tests are slow by folder or mark, and need a browser where they ask for the fixture.

    All processes have them in the same order.
    """
    items.sort(key=lambda item: item.path.parts)
    for item in items:
        if item.path.is_relative_to(HERE) and item.path.relative_to(HERE).parts[0] == "slow":
            item.add_marker(pytest.mark.slow)
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


# Files whose tests take the same results, those of tests/helpers/results.py or the paper's linear figures,
# which each process has to compute; so one process runs them.
TOGETHER = {
    "results": ("results_in_hand.py", "round_trips.py", "results_plot.py", "appearance.py"),
    "paper": ("linear_figures.py", "claims.py"),
}


@pytest.hookimpl(optionalhook=True)  # where xdist is installed
def pytest_xdist_make_scheduler(config, log):
    """A file's tests run in one process, which makes what they share once."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return next((name for name, ends in TOGETHER.items() if file.endswith(ends)), file)

    return Scheduling(config, log) if config.getvalue("dist") == "load" else None


CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


# Not for the whole run: an event loop runs as long, which tests that run notebooks would stumble over.
@pytest.fixture(scope="module")
def browser():
    """Chromium, driven by playwright."""
    api = pytest.importorskip(
        "playwright.sync_api", reason="playwright drives the browser; it is not installed"
    )
    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if path is None:
        pytest.skip(f"a browser draws this, none is installed: {', '.join(CHROMIUM)}")
    with api.sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()
