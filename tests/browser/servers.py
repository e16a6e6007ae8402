"""Voila and JupyterLab as processes of their own, on a free port, with settings of nobody."""

import json
import os
import re
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

import psutil

ROOT = Path(__file__).parents[2]
PATIENCE = 60  # seconds

# An explorer, a run that is watched, a plane and a diagram to click into.  The kernel counts what the
# controls say.  One cell, as JupyterLab takes others off the page where they are out of sight.
CELL = """\
import frictionlab as fl
import ipywidgets

explorer = fl.explore(fl.SliderOnBelt(mu_k=1.4), panels=("response", "phase"))
explorer.controls["duration"].value = 2.0
explorer.widget.add_class("live")
heard = ipywidgets.Label("0").add_class("live-heard")
def count(change):
    heard.value = str(int(heard.value) + 1)
for control in explorer.controls.values():
    control.observe(count, names="value")
watched = fl.watch(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0, progress=False), speed=0.2)
plane, diagram = fl.explore_stability(), fl.explore_bifurcation(fl.SliderOnBelt().without("geometry"))
plane.widget.add_class("plane")
diagram.widget.add_class("diagram")
display(heard, explorer, watched.add_class("watched"), plane, diagram)
"""


# A film, which takes long enough for a bar of progress to appear and to vanish.
ANIMATED = """\
import frictionlab as fl

fl.animate(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.5), fps=5)
"""

LAB = (
    "--no-browser",
    "--allow-root",
    "--ServerApp.port_retries=0",
    "--IdentityProvider.token=",
    "--LabApp.news_url=None",
    "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
)


# The explorer of all models, as `frictionlab app` shows it.
SCENES = """\
from frictionlab.widgets.scenes import Scenes

Scenes()
"""


def write_notebook(folder, source=CELL):
    """A notebook of one cell; returns its path."""
    cell = {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": source}
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    data = {"cells": [cell], "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}
    path = folder / "page.ipynb"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def free_port():
    """A port that nobody listens at."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def environment(folder):
    """The variables of this process, with this package and with Jupyter's own files in a folder."""
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    own = {f"JUPYTER_{name}_DIR": str(folder / name) for name in ("CONFIG", "RUNTIME")}
    own |= {f"JUPYTERLAB_{name}_DIR": str(folder / name) for name in ("SETTINGS", "WORKSPACES")}
    return os.environ | own | {"IPYTHONDIR": str(folder / "ipython"), "PYTHONPATH": path}


def in_lab(folder, port):
    return ["jupyterlab", *LAB, f"--port={port}", f"--ServerApp.root_dir={folder}"]


def app(folder, port):
    return ["frictionlab", "app", "--no-browser", "--port", str(port)]


def run_all(page):
    """Lab's way to the outputs."""
    page.locator(".jp-Notebook .jp-CodeCell").first.wait_for(timeout=1000 * PATIENCE)
    page.get_by_text("| Idle").wait_for(timeout=1000 * PATIENCE)  # without a kernel it runs nothing
    page.locator(".lm-MenuBar-item").get_by_text("Run", exact=True).click()
    page.locator(".lm-Menu-item").get_by_text("Run All Cells", exact=True).click()


@contextmanager
def serving(arguments, port, folder):
    """`python -m arguments`, from when it answers at the port until the block is done; yields its address."""
    log = folder / "server.log"
    with log.open("w") as stream:
        command = [sys.executable, "-m", *arguments]
        process = subprocess.Popen(command, cwd=folder, env=environment(folder), stdout=stream, stderr=stream)
    try:
        _wait(process, port, log)
        yield f"http://localhost:{port}"
    finally:
        process.terminate()  # the server ends its kernels
        process.wait(PATIENCE)


def printed_path(folder):
    """The path of the explorer's link that a server of the folder printed, with its token."""
    link = re.search(r"Python at http://localhost:\d+(/\S*)", (folder / "server.log").read_text())
    return link[1]


def running_kernels():
    """How many kernels this process's servers have."""
    kernels = 0
    for child in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # it ends just now
            kernels += "ipykernel_launcher" in child.cmdline()
    return kernels


def _wait(process, port, log):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        try:
            return urlopen(f"http://localhost:{port}/static/nothing", timeout=5).close()
        except URLError as error:
            if hasattr(error, "code"):  # any answer is one
                return error.close()
            time.sleep(0.2)
        except OSError:
            time.sleep(0.2)
    raise AssertionError(f"the server does not answer: {log.read_text()}")
