"""What tests of the explorer share."""

import base64
import json

import numpy as np

import frictionlab as fl
from frictionlab.pages.export import text_of
from tests.unit.pages.test_javascript import run_in_node

SHORT = ("response", "phase")
SCRIPTS = "text", "plot", "turns", "friction", "panels", "controls", "state", "words", "challenge"


def made(model=None, panels=SHORT, seconds=1.0):
    explorer = fl.explore(model, panels)
    explorer.controls["duration"].value = seconds
    assert explorer.error is None
    return explorer


def columns(widget):
    """What the front end gets of a run: times, modes, states and outputs."""
    samples = widget.picture["samples"]
    names = widget.picture["structure"]["modes"]
    modes = np.frombuffer(samples["modes"]).astype(int)
    found = {name: np.frombuffer(values) for name, values in samples["columns"].items()}
    return {"t": np.frombuffer(samples["times"]), "mode": np.array(names)[modes], **found}


def curve(explorer, panel, label):
    """The data of a curve of a panel of one's own."""
    found = explorer.drawings[panel].curves[label]
    return np.asarray(found.x), np.asarray(found.y)


def said(widget, expression):
    """An expression of the front end's scripts, of the `result` that a widget shows."""
    text = json.dumps(widget.picture, default=lambda data: {"base64": base64.b64encode(data).decode()})
    scripts = "".join(text_of(f"{name}.js") for name in SCRIPTS)
    numbers = "(o) => new Float64Array(new Uint8Array(Buffer.from(o.base64, 'base64')).buffer)"
    return run_in_node(
        f"""{scripts}
        const floats = {numbers}, picture = JSON.parse({json.dumps(text)}), result = {{ ...picture }};
        const {{ samples, spectrum: lines }} = picture;
        if (samples) result.samples = samplesByName(floats(samples.times), floats(samples.modes),
          Object.keys(samples.columns), Object.values(samples.columns).map(floats));
        if (lines) Object.assign(lines, {{ frequencies: floats(lines.frequencies),
          amplitudes: floats(lines.amplitudes) }});
        result.highest = {json.dumps(widget.scene["highest"])};
        const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
        console.log(JSON.stringify({expression}, plain));"""
    )


def words(explorer):
    """The verdict on steady sliding and the run."""
    return said(explorer.widget, "verdict(result)")


# Every model of the package, by the call that makes it.
MODELS = {row.call: eval(f"fl.{row.call}", {"fl": fl}) for row in fl.list_models("classics")}
