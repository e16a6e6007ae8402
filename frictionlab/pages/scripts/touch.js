// A body of the mechanism is dragged, by a mouse, a finger or the arrow keys: the motion starts where it is let go.
//
// A body is {box: [x, y, width, height], along: {coordinate: what a step (dx, dy) changes it by, ...}}, in units of the
// picture.
const FINGER = 18; // pixels around a body that count as the body
const LEAST_DRAG = 3; // pixels; less is a click
const KEY_STEP = 0.01; // share of the picture's height by which an arrow key moves a body
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
const TOUCH_HINT = "drag a body: the motion starts there";
const TOUCH_KEYS = "Drag a body, or choose one with n and move it with the arrow keys; Enter starts the motion there";

// A pointer drags what `find` has under it, if anything; beside it a finger scrolls the page.
function letDrag(over, find, { grip, pull, release, cancel }) {
  let held = false;
  const onSomething = (event) => { if (find(event.touches[0])) event.preventDefault(); };
  over.addEventListener("touchstart", onSomething, { passive: false });
  over.onpointerdown = (event) => {
    const found = find(event);
    if (!found) return;
    held = true;
    grip(found, event);
    over.setPointerCapture(event.pointerId);
  };
  over.onpointermove = (event) => { if (held) pull(event); else over.style.cursor = find(event) ? "grab" : ""; };
  over.onpointerup = (event) => { if (held) release(event); held = false; };
  over.onpointercancel = () => { held = false; cancel(); };
}

class BodyDrag {
  constructor(explorer, over) {
    Object.assign(this, { explorer, over, chosen: null, from: null, touched: {}, framed: false });
    Object.assign(over, { tabIndex: 0, title: TOUCH_KEYS, ariaLabel: TOUCH_KEYS, role: "application" });
    letDrag(over, (event) => this.bodyAt(event), {
      grip: (body, event) => this.begin(body, [event.clientX, event.clientY]),
      pull: (event) => this.pull(event), release: () => this.release(), cancel: () => this.cancel(),
    });
    over.onblur = () => this.cancel();
    over.onkeydown = (event) => this.key(event);
  }

  get bodies() { return this.explorer.picture?.bodies(...this.explorer.shownSample()) ?? []; }

  get scale() { // pixels for a unit, and the place of the origin
    const { explorer, over } = this, [[x0, x1], [y0, y1]] = explorer.picture.scene.limits;
    const width = over.clientWidth / (explorer.kept?.picture ? 2 : 1), height = over.clientHeight;
    const k = Math.min(width / (x1 - x0), height / (y1 - y0));
    return { k, x: (width - k * (x1 - x0)) / 2 - k * x0, y: (height + k * (y1 - y0)) / 2 + k * y0, height: y1 - y0 };
  }

  bodyAt({ clientX, clientY }) { // the body under a pointer, or the nearest one that a finger reaches
    if (!this.explorer.picture) return null;
    const box = this.over.getBoundingClientRect(), scale = this.scale;
    const away = ({ box: [x, y, w, h] }) => Math.hypot(
      Math.max(0, Math.abs(clientX - box.left - scale.x - scale.k * x) - scale.k * w / 2),
      Math.max(0, Math.abs(clientY - box.top - scale.y + scale.k * y) - scale.k * h / 2),
    );
    const near = this.bodies.map((body) => [away(body), body]).filter(([distance]) => distance <= FINGER);
    return near.sort(([a], [b]) => a - b)[0]?.[1] ?? null;
  }

  begin(body, from) { // other bodies go where they are in steady sliding
    const shown = this.explorer.shownSample(), [samples, i] = shown;
    const now = Object.fromEntries(Object.keys(body.along).map((name) => [name, samples.column(name)[i]]));
    Object.assign(this, { body, from, now, shown, touched: {} });
  }

  pull(event) {
    if (!this.from) return; // Escape has let it go
    const dx = event.clientX - this.from[0], dy = event.clientY - this.from[1];
    if (this.explorer.held || Math.hypot(dx, dy) >= LEAST_DRAG) this.move(dx / this.scale.k, -dy / this.scale.k);
  }

  move(dx, dy) { // by so many units of the picture from where it was
    const { explorer, body, now } = this;
    const to = (name, v) => (doesTurn(explorer.result, name) ? withinTurn(v) : v);
    this.touched = Object.fromEntries(Object.entries(body.along).map(([name, change]) =>
      [name, to(name, now[name] + change(dx, dy))]));
    explorer.held = heldSample(explorer.result, this.touched, this.shown);
    explorer.frame();
  }

  text() { // "x1 = 0.1 m": where the body is held
    const { labels, units } = this.explorer.result.structure;
    return Object.entries(this.touched).map(([name, v]) =>
      `${plainLabel(labels[name])} = ${shortNumber(v, 3)} ${units[name]}`).join(", ");
  }

  release() {
    const { explorer, touched, now } = this, far = (name) => Math.abs(touched[name] - now[name]);
    const names = Object.keys(touched).sort((a, b) => far(b) - far(a));
    this.from = null;
    if (names.length) explorer.startAt(touched, names[0]);
  }

  cancel() {
    Object.assign(this, { from: null, touched: {}, chosen: null });
    this.explorer.held = null;
    this.explorer.frame();
  }

  key(event) {
    const { bodies } = this, arrow = ARROWS[event.key];
    if (!bodies.length || event.ctrlKey || event.metaKey || event.altKey) return;
    if (!arrow && !["n", "Enter", "Escape"].includes(event.key)) return;
    event.preventDefault();
    event.stopPropagation();
    const { chosen } = this;
    if (event.key === "Enter") this.release();
    if (!arrow) this.cancel();
    if (event.key === "n") this.chosen = chosen === null ? 0 : (chosen + 1) % bodies.length;
    if (arrow) this.step(bodies[this.chosen = (chosen ?? 0) % bodies.length], arrow);
    this.explorer.frame();
  }

  step(body, arrow) {
    if (!this.explorer.held) {
      this.begin(body, null);
      this.steps = [0, 0];
    }
    this.steps = this.steps.map((sum, i) => sum + arrow[i] * KEY_STEP * this.scale.height);
    this.move(...this.steps);
  }

  paint(look) { // a frame around the body that the keys move
    const body = this.chosen === null ? null : this.bodies[this.chosen];
    if (!body && !this.framed) return;
    const [c] = fit(this.over);
    this.framed = Boolean(body);
    if (!body) return;
    const { k, x, y } = this.scale, [left, up, w, h] = body.box;
    Object.assign(c, { strokeStyle: look.ink, lineWidth: 2 });
    c.setLineDash([4, 3]);
    c.strokeRect(x + k * (left - w / 2) - 4, y - k * (up + h / 2) - 4, k * w + 8, k * h + 8);
  }
}

function heldSample(result, touched, shown) { // the state of a body that is held, as the sample of an instant
  const { structure: { states }, samples } = result, start = startState(result, touched, shown),
    [{ modes }, i] = shown, outputs = Object.keys(samples.byName);
  const values = outputs.map((name) => Float64Array.of(states.includes(name) ? start[states.indexOf(name)] : 0));
  return samplesByName(Float64Array.of(0), Int32Array.of(modes[i]), outputs, values);
}

// All else as in steady sliding. Where a cyclic coordinate is touched, the others stay where they are beside it: all
// turn back by as many turns as it does.
function startState(result, touched, [samples, i]) {
  const { structure: { states, cyclic }, equilibrium } = result, now = (name) => samples.column(name)[i];
  const one = cyclic.find((name) => name in touched),
    turns = one && doesTurn(result, one) ? Math.round((now(one) - touched[one]) / TURN) : 0;
  const other = (name, place) => (one && cyclic.includes(name) ? now(name) - TURN * turns : equilibrium?.state[place]);
  return states.map((name, place) => touched[name] ?? other(name, place) ?? 0);
}
