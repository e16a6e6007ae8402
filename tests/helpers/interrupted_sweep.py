"""A sweep that tests cut off from outside: FILE threads | continue | processes | basins."""

import signal
import sys
import time
from concurrent.futures import ProcessPoolExecutor

import frictionlab as fl

MODEL = fl.SliderOnBelt().without("geometry")
VALUES = [0.5 + 0.1 * i for i in range(12)]
SETTINGS = {"transient": 10.0, "window": 5.0, "progress": False}


def slow(model):
    """Any function, slow enough to be cut off."""
    time.sleep(0.3)
    return {"mu_k": model.mu_k}


def main(path, kind):
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background
    try:
        sweep(path, kind)
    except KeyboardInterrupt:
        found = fl.partial_result()
    if isinstance(found, fl.Sweep):
        done = sum(result is not None for result in found.results)
    else:
        done = len(found.results)
    print("kept", done, flush=True)


def sweep(path, kind):
    if kind == "processes":
        with ProcessPoolExecutor(2) as pool:
            fl.sweep(MODEL, slow, {"mu_k": VALUES}, executor=pool, resume=path, progress=False)
    elif kind == "basins":
        speeds = ("x1'", VALUES), ("y1'", VALUES)
        fl.basins(MODEL.replace(mu_k=1.4), *speeds, workers=1, resume=path, **SETTINGS)
    else:
        x0 = "continue" if kind == "continue" else "rest"
        fl.bifurcation(MODEL, "mu_k", VALUES, x0, workers=1, resume=path, **SETTINGS)


if __name__ == "__main__":
    main(*sys.argv[1:])
