"""A sweep that tests cut off from outside: FILE threads | continue | processes | basins."""

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
    if kind == "processes":
        with ProcessPoolExecutor(2) as pool:
            found = fl.sweep(MODEL, slow, {"mu_k": VALUES}, executor=pool, resume=path, progress=False)
        done = sum(result is not None for result in found.results)
    elif kind == "basins":
        speeds = ("x1'", VALUES), ("y1'", VALUES)
        found = fl.basins(MODEL.replace(mu_k=1.4), *speeds, workers=1, resume=path, **SETTINGS)
        done = len(found.results)
    else:
        x0 = "continue" if kind == "continue" else "rest"
        found = fl.bifurcation(MODEL, "mu_k", VALUES, x0, workers=1, resume=path, **SETTINGS)
        done = sum(kind != "" for kind in found.kinds)
    print("came back with", done, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
