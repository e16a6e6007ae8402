// The friction curve: coefficient over speed, its slope at the speed of steady sliding, and points that are dragged.
const NEAREST_POINTS = 0.01; // share of the speeds that are shown, by which two points stay apart

function frictionDrawing({ friction, parameters }, points) {
  if (!friction) return null;
  const { speeds, mu, at } = friction, reach = speeds.at(-1),
    curves = /** @type {any[]} */ ([{ label: "_friction", x: speeds, y: mu, width: 2 }]);
  const handles = points.map(([speed, coefficient]) =>
    ({ x: speed ? parameters[speed] : 0, y: parameters[coefficient], speed, coefficient }));
  let note = handles.length ? "drag the points" : "";
  if (at) {
    const [v, here, slope, damper] = at, ends = [Math.max(0, v - 0.25 * reach), Math.min(reach, v + 0.25 * reach)];
    curves.push({ label: "slope at steady sliding", x: ends, y: ends.map((u) => here + slope * (u - v)),
      colour: "#D55E00", dash: true });
    note = `${shortNumber(v, 3)} m/s: like a damper of ${shortNumber(damper, 3).replace("-",
      "−")} N s/m\n${note}`.trim();
  }
  if (handles.length) curves.push({ label: "_points", x: handles.map(({ x }) => x), y: handles.map(({ y }) => y),
    colour: "#0072B2", marker: "o", size: 13, line: false });
  const top = Math.max(largest([mu]), ...handles.map(({ y }) => y)) || 1;
  return { xlabel: "sliding speed (m/s)", ylabel: "coefficient of friction", curves, note, handles, xlim: [0, reach],
    ylim: [0, roundStep(1.25 * top)] };
}

class PointDrag { // of the points of the curve; the parameters follow, and with them motion and stability
  constructor(explorer, panel) {
    Object.assign(this, { explorer, panel, held: null });
    const { over } = panel;
    over.addEventListener("touchstart", (event) => { if (this.near(event.touches[0]) >= 0) event.preventDefault(); },
      { passive: false });
    over.onpointerdown = (event) => this.grip(event);
    over.onpointermove = (event) => this.pull(event, true);
    over.onpointerup = (event) => { this.pull(event, false); this.held = null; };
    over.onpointercancel = () => { this.held = null; };
  }

  near({ clientX, clientY }) { // the number of the point under a pointer; -1 without one
    const { panel: { over, drawing, axes } } = this, box = over.getBoundingClientRect();
    if (!drawing?.handles || !axes) return -1;
    const away = drawing.handles.map(({ x, y }) =>
      Math.hypot(axes.X.at(x) - clientX + box.left, axes.Y.at(y) - clientY + box.top));
    const place = away.indexOf(Math.min(...away));
    return away[place] <= FINGER ? place : -1;
  }

  grip(event) {
    const place = this.near(event), { panel } = this;
    if (place < 0) return;
    this.held = { place, axes: panel.axes, handles: panel.drawing.handles };
    panel.over.setPointerCapture(event.pointerId);
  }

  pull(event, dragging) { // on the axes on which it was taken: those that are drawn follow the curve
    if (!this.held) {
      this.panel.over.style.cursor = this.near(event) < 0 ? "" : "grab";
      return;
    }
    const { place, axes: { X, Y }, handles } = this.held, box = this.panel.over.getBoundingClientRect(),
      apart = NEAREST_POINTS * X.high;
    const between = (low, value, high) => roundNumber(Math.min(Math.max(value, low), high), 4);
    const { speed, coefficient } = handles[place], right = handles[place + 1]?.x ?? Infinity;
    const moved = { [coefficient]: between(0, Y.value(event.clientY - box.top), Infinity) };
    if (speed) moved[speed] = between(handles[place - 1].x + apart, X.value(event.clientX - box.left), right - apart);
    this.explorer.changeAll(moved, dragging, true);
  }
}
