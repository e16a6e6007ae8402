"""A page of its own for the canvas's JavaScript: a model that answers `get` as anywidget's does, and hears
of nothing else."""

import base64

import numpy as np

START = """async ({ code, scene, rows }) => {
  const module = await import(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  const bytes = Uint8Array.from(atob(rows), (c) => c.charCodeAt(0));
  const padded = new Uint8Array(bytes.length + 3); // messages of a kernel do not care about alignment
  padded.set(bytes, 3);
  const values = { scene, rows: new DataView(padded.buffer, 3) };
  const el = document.createElement("div");
  document.body.append(el);
  const model = { get: (name) => values[name], on: () => {}, off: () => {} };
  window.stop = module.default.render({ model, el });
  await new Promise((done) => setTimeout(done, 200));
}"""


def open_canvas(page, canvas):
    """Show a canvas in a page of a browser."""
    page.set_content("<!doctype html><body style='margin: 0'></body>")
    rows = base64.b64encode(canvas.rows).decode()
    page.evaluate(START, {"code": canvas._esm, "scene": canvas.scene, "rows": rows})


def scrub(page, frame):
    """Move the slider under the picture; returns the line of text."""
    script = "(v) => { const s = document.querySelector('input'); s.value = v; s.oninput() }"
    page.evaluate(script, frame)
    return page.locator("span").first.inner_text()


def picture_of(page, canvas):
    """Pixels (height, width, 4) of the canvas of that number."""
    script = """(index) => {
      const c = document.querySelectorAll("canvas")[index];
      const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
      let text = "";
      for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
      return [c.height, c.width, btoa(text)];
    }"""
    height, width, text = page.evaluate(script, canvas)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)


def pixels_of(page, canvas, colour):
    """Box (left, right, top, bottom) of the pixels that have exactly a colour, or None."""
    y, x = np.nonzero((picture_of(page, canvas) == [*bytes.fromhex(colour[1:]), 255]).all(axis=2))
    return (x.min(), x.max(), y.min(), y.max()) if len(x) else None
