"""What tests of the explorer share."""

from io import BytesIO

import numpy as np
from PIL import Image

import frictionlab as fl

SHORT = ("response", "phase")


def made(model=None, panels=SHORT, seconds=1.0):
    explorer = fl.explore(model, panels)
    explorer.controls["duration"].value = seconds
    assert explorer.error is None
    return explorer


def lines(explorer, panel):
    return explorer.picture.tiles[panel].lines


def pixels(explorer, panel):
    return np.asarray(Image.open(BytesIO(explorer.picture.images[panel].value)).convert("RGB"))


# Every model of the package, by the call that makes it.
MODELS = {row.call: eval(f"fl.{row.call}", {"fl": fl}) for row in fl.list_models("classics")}
