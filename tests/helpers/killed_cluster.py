"""A sweep on a cluster whose workers or scheduler are killed meanwhile: FILE workers | scheduler."""

import os
import random
import signal
import subprocess
import sys
import threading
import time

import numpy as np

import frictionlab as fl


def friction(model):
    """Any function, slow enough for what it runs on to be killed."""
    time.sleep(0.05)
    return {"friction": model.F * model.mu_k}


class Cluster:
    """A scheduler and two workers, processes of their own."""

    def __init__(self):
        self.address = f"tcp://127.0.0.1:{random.randrange(20_000, 40_000)}"
        self.scheduler = self._process("scheduler", "--port", self.address.rsplit(":", 1)[1])
        time.sleep(3.0)
        self.workers = [self.worker(), self.worker()]

    def worker(self):
        return self._process("worker", self.address, "--nworkers", "1", "--nthreads", "1", "--no-nanny")

    def _process(self, kind, *arguments):
        module = f"distributed.cli.dask_{kind}"
        return subprocess.Popen(
            [sys.executable, "-m", module, *arguments, "--no-dashboard"], stderr=subprocess.DEVNULL
        )

    def kill_workers(self):
        for worker in tuple(self.workers):
            time.sleep(1.5)
            worker.send_signal(signal.SIGKILL)
            self.workers.append(self.worker())

    def kill_scheduler(self):
        time.sleep(2.0)
        self.scheduler.send_signal(signal.SIGKILL)

    def end(self):
        for process in (self.scheduler, *self.workers):
            process.kill()


def sweep(path, kill):
    """The sweep on a cluster of which something is killed."""
    from distributed import Client

    cluster = Cluster()
    client = Client(cluster.address, timeout="30s")
    client.wait_for_workers(2)
    threading.Thread(target=getattr(cluster, kill), daemon=True).start() if kill else None
    try:
        grid = {"mu_k": np.linspace(0, 3, 100)}
        fl.sweep(
            fl.SliderOnBelt(), friction, grid, executor=client.get_executor(), resume=path, progress=False
        )
    except RuntimeError as error:
        print(error, flush=True)
        sweep(path, "")
    finally:
        cluster.end()


if __name__ == "__main__":
    sys.modules["tests.helpers.killed_cluster"] = sys.modules["__main__"]
    friction.__module__ = "tests.helpers.killed_cluster"  # by which workers import it
    sweep(sys.argv[1], f"kill_{sys.argv[2]}")
    sys.stdout.flush()
    os._exit(0)  # a client whose scheduler is lost would wait for it
