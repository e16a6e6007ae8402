// A drawing, painted: axes with ticks, labels and a legend, and its curves.
//
// A drawing is {xlabel, ylabel, right, curves, log, note, xlim, ylim, turns}; a curve {label, x, y, colour, width,
// dash, marker, line, axis}. `turns` says of x, left and right whether they have angles that turn. A label that begins
// with "_" is not in the legend. The axis is "left", "right" or "strip", on which 0 is the bottom of the panel and 1
// its top. A number that is not finite breaks a line.
const LEAST_FILL = 0.35; // share of an axis that the data have to fill, or else the axis shrinks
const LINE_WIDTH = 1.3; // pixels; one of 1 is painted in half the time
const LIMIT_MARGIN = 0.06, LEAST_RANGE = 1e-12;
const LEAST_RELATIVE_RANGE = 1e-2; // of the largest value: what varies less is drawn as the constant it is
const DECADES = 5; // of a logarithmic axis

function dataRange(arrays) { // smallest and largest finite number, or null
  let [low, high] = [Infinity, -Infinity];
  for (const values of arrays) {
    for (const v of values) {
      if (v < low && v !== -Infinity) low = v;
      if (v > high && v !== Infinity) high = v;
    }
  }
  return low <= high ? [low, high] : null;
}

function roundStep(step) {
  const power = 10 ** Math.floor(Math.log10(step));
  return [1, 2, 2.5, 5, 10].find((s) => s * power >= step * (1 - 1e-9)) * power;
}

// the present limits, if the data are inside and fill them; else new round ones
function linearLimits(now, needed, least = LEAST_RELATIVE_RANGE) {
  if (!needed) return now ?? [0, 1];
  if (!needed[0] && !needed[1]) return [-1, 1];
  const missing = Math.max(0, Math.max(least * Math.max(...needed.map(Math.abs)), LEAST_RANGE)
    - (needed[1] - needed[0])) / 2;
  const [low, high] = [needed[0] - missing, needed[1] + missing];
  if (now && now[0] <= needed[0] && needed[1] <= now[1] && high - low >= LEAST_FILL * (now[1] - now[0])) return now;
  const margin = LIMIT_MARGIN * (high - low), step = roundStep((high - low + 2 * margin) / 5);
  return [Math.floor((low - margin) / step) * step, Math.ceil((high + margin) / step) * step];
}

function logarithmicLimits(now, needed) {
  if (!needed || needed[1] <= 0) return now ?? [10 ** -DECADES, 1];
  const top = Math.log10(needed[1]), before = now && Math.log10(now[1]);
  if (now && before - 1.5 < top && top < before) return now;
  return [10 ** (Math.floor(top) + 1 - DECADES), 10 ** (Math.floor(top) + 1)];
}

function turnLimits(now, needed, least) { // multiples of pi/2 where more than pi is shown
  if (needed && needed[1] - needed[0] <= Math.PI) return linearLimits(now, needed, least);
  const [low, high] = (needed ?? [-Math.PI, Math.PI]).map((angle) => 2 * angle / Math.PI),
    first = Math.floor(low + 1e-9);
  return [first, Math.max(Math.ceil(high - 1e-9), first + 1)].map((halves) => Math.PI / 2 * halves);
}

class Axis { // from data to pixels, and back
  constructor([low, high], [start, stop], log = false, turns = false) {
    Object.assign(this, { low, high, start, stop, log, turns });
    this.from = log ? Math.log10(low) : low;
    this.span = (log ? Math.log10(high) : high) - this.from || 1;
  }

  at(v) { return this.start + (this.stop - this.start) * ((this.log ? Math.log10(Math.max(v, 1e-300)) : v)
    - this.from) / this.span; }

  value(pixel) {
    const v = this.from + this.span * (pixel - this.start) / (this.stop - this.start);
    return this.log ? 10 ** v : v;
  }

  ticks(space) { // {values, texts, power}: round numbers some `space` pixels apart, written in units of 10^power
    if (this.log) {
      const count = Math.round(this.span),
        values = Array.from({ length: count + 1 }, (_, i) => 10 ** Math.round(this.from + i));
      return { values, texts: values.map((v) => `10${raised(Math.round(Math.log10(v)))}`), power: 0 };
    }
    const least = this.span / Math.max(2, Math.floor(Math.abs(this.stop - this.start) / space));
    if (this.turns && this.span > Math.PI) {
      const half = Math.PI / 2, by = Math.ceil(roundStep(Math.max(least / half, 1))),
        first = Math.ceil(this.low / half / by - 1e-9), last = Math.floor(this.high / half / by + 1e-9);
      const halves = Array.from({ length: last - first + 1 }, (_, i) => by * (first + i));
      return { values: halves.map((n) => half * n), texts: halves.map(multipleOfPi), power: 0 };
    }
    const step = roundStep(least);
    const first = Math.ceil(this.low / step - 1e-9), last = Math.floor(this.high / step + 1e-9);
    const values = Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
    const size = Math.floor(Math.log10(Math.max(...values.map(Math.abs), step))),
      power = size > 4 || size < -2 ? size : 0;
    const digits = [0, 1, 2, 3, 4, 5, 6, 7,
      8].find((n) => Math.abs(step / 10 ** power
      - Number((step / 10 ** power).toFixed(n))) < 1e-6 * step / 10 ** power) ?? 9;
    return { values, texts: values.map((v) =>
      (v / 10 ** power).toFixed(digits).replace(/^-(?=.*[1-9])/, "−").replace(/^-/, "")), power };
  }
}

const withPower = (label, power) => !power ? label : label.endsWith(")")
  ? label.replace(/\(([^()]*)\)$/, `(10${raised(power)} $1)`) : `${label} (10${raised(power)})`;

// A line breaks where a number is not finite.  Of points within a pixel, and of those on a level in one direction, the
// last is painted.
function paintLine(c, x, y, X, Y) {
  let [px, py, begun, lu, lv] = [0, 0, false, NaN, NaN]; // the last point that is painted; the one that was left out
  const paint = (u, v) => {
    begun ? c.lineTo(u, v) : c.moveTo(u, v);
    [px, py, begun, lu, lv] = [u, v, true, NaN, NaN];
  };
  const catchUp = () => { if (Number.isFinite(lu)) paint(lu, lv); };
  c.beginPath();
  for (let i = 0; i < x.length; i++) {
    const u = X.at(x[i]), v = Y.at(y[i]);
    if (!Number.isFinite(u + v)) { catchUp(); begun = false; continue; }
    if (lv === py && (v !== py || Math.abs(lu - px) >= 1 && (u - lu) * (lu - px) < 0)) catchUp();
    const near = Math.abs(u - px) < 1 && Math.abs(v - py) < 1;
    if (begun && (near || v === py)) [lu, lv] = [u, v]; else paint(u, v);
  }
  catchUp();
  c.stroke();
}

const MARKERS = { // around (0, 0), of half the size r
  o: (c, r) => c.arc(0, 0, r, 0, 7),
  s: (c, r) => c.rect(-r, -r, 2 * r, 2 * r),
  "^": (c, r) => { c.moveTo(0, -r); c.lineTo(r, r); c.lineTo(-r, r); c.closePath(); },
  D: (c, r) => { c.moveTo(0, -r); c.lineTo(r, 0); c.lineTo(0, r); c.lineTo(-r, 0); c.closePath(); },
  "+": (c, r) => { c.moveTo(-r, 0); c.lineTo(r, 0); c.moveTo(0, -r); c.lineTo(0, r); },
  _: (c, r) => { c.moveTo(-r, 0); c.lineTo(r, 0); },
  x: (c, r) => { c.moveTo(-r, -r); c.lineTo(r, r); c.moveTo(r, -r); c.lineTo(-r, r); },
};

function paintMarker(c, marker, size, x, y) {
  c.save();
  c.translate(x, y);
  c.beginPath();
  (MARKERS[marker] ?? MARKERS.o)(c, size / 2);
  "+x_".includes(marker) ? c.stroke() : c.fill();
  c.restore();
}

function paintCurve(c, curve, X, Y, look, dotted, fine) {
  const colour = dotted && curve.colour === "#999999" ? look.ink : legible(curve.colour, look),
    width = curve.width ?? (fine ? 1 : LINE_WIDTH);
  Object.assign(c, { strokeStyle: colour, fillStyle: colour, lineWidth: dotted ? Math.max(1.6, width) : width,
    lineJoin: "round" });
  c.setLineDash(dotted ? [2, 3] : (curve.dash ?? []).map((part) => part * width));
  if (curve.line !== false) paintLine(c, curve.x, curve.y, X, Y);
  c.setLineDash([]);
  if (curve.marker) for (let i = 0; i < curve.x.length;
    i++) if (Number.isFinite(curve.y[i])) paintMarker(c, curve.marker, curve.size ?? 7, X.at(curve.x[i]),
    Y.at(curve.y[i]));
}

const legible = (colour = "#000000", look) => (colour === "#000000" ? look.ink
  : look.dark ? `oklch(from ${colour} max(l, 0.7) c h)` : colour); // the nearest light shade, on a dark background

function legendRows(c, curves, width, size) { // rows of [curve, x]
  const rows = [[]];
  let x = 0;
  for (const curve of curves.filter(({ label }) => !label.startsWith("_"))) {
    const needed = labelWidth(c, curve.label, size) + 2.6 * size;
    if (x && x + needed > width) { rows.push([]); x = 0; }
    rows.at(-1).push([curve, x]);
    x += needed;
  }
  return rows[0].length ? rows : [];
}

function paintLegend(c, rows, left, size, look) {
  rows.forEach((row, i) => row.forEach(([curve, x]) => {
    const y = (0.8 + 1.35 * i) * size, thick = curve.width > 4, at = left + x;
    const colour = legible(curve.colour, look);
    Object.assign(c, { strokeStyle: colour, fillStyle: colour,
      lineWidth: thick ? 0.6 * size : Math.max(2, curve.width ?? LINE_WIDTH) });
    c.setLineDash((curve.dash ?? []).map((part) => part * Math.min(c.lineWidth, 2)));
    c.beginPath();
    c.moveTo(at, y);
    c.lineTo(at + 1.2 * size, y);
    if (curve.line !== false) c.stroke();
    c.setLineDash([]);
    if (curve.line === false || !thick && curve.marker) paintMarker(c, curve.marker, Math.max(5, curve.size ?? 7),
      at + 0.6 * size, y);
    c.fillStyle = look.ink;
    paintLabel(c, curve.label, at + 1.6 * size, y, size);
  }));
}

// Where axes, ticks and legend of a drawing are, with room for one that is kept for comparison; the layout of the last
// drawing, where nothing of that has changed. `memory` keeps it, and the limits of the axes.
function layoutOf(c, width, height, drawing, look, memory, kept = null) {
  const all = [...drawing.curves, ...(kept?.curves ?? [])], { xlabel, ylabel, right: label, log } = drawing;
  const of = (axis) => dataRange(all.filter((curve) => (curve.axis ?? "left") === axis).map(({ y }) => y));
  const turns = drawing.turns ?? {}, linear = (axis) => (turns[axis] ? turnLimits : linearLimits);
  memory.x = drawing.xlim ?? linear("x")(memory.x, dataRange(all.map(({ x }) => x)));
  memory.left = drawing.ylim ?? (log ? logarithmicLimits : linear("left"))(log === memory.log ? memory.left : null,
    of("left"), drawing.least);
  if (label) memory.right = linear("right")(memory.right, of("right"));
  memory.log = log;
  const { x, left, right } = memory, legend = drawing.curves.map(({ x: _, y, ...curve }) => curve);
  const key = JSON.stringify([width, height, xlabel, ylabel, label, log, turns, x, left, label && right, legend, look]);
  if (memory.layout?.key !== key) memory.layout = { key, look, xlabel, ylabel, label,
    ...placesOf(c, width, height, drawing, look, memory) };
  return memory.layout;
}

function placesOf(c, width, height, { curves, right: hasRight, log, turns }, look, memory) {
  const em = look.letters, small = 0.86 * em, rows = legendRows(c, curves, width - 2 * em, small);
  const top = 0.8 * em + 1.35 * small * rows.length, bottom = height - 2.9 * em;
  const Y = new Axis(memory.left, [bottom, top], log, turns?.left), yTicks = Y.ticks(2.4 * em);
  const R = hasRight ? new Axis(memory.right, [bottom, top], false, turns?.right) : null, rTicks = R?.ticks(2.4 * em);
  c.font = `${small}px system-ui, sans-serif`;
  const widest = (ticks) => Math.max(...ticks.texts.map((text) => c.measureText(text).width));
  const left = widest(yTicks) + 2.4 * em, right = width - (R ? widest(rTicks) + 2.4 * em : 1.8 * em);
  const X = new Axis(memory.x, [left, right], false, turns?.x), xTicks = X.ticks(4.8 * em);
  return { X, Y, R, xTicks, yTicks, rTicks, rows, em, small, width, height, left, right, top, bottom };
}

function paintFrame(c, layout) { // all but the curves: grid, ticks, labels, legend
  const { X, Y, R, xTicks, yTicks, rTicks, rows, em, small, width, height, left, right, top, bottom, look } = layout;
  Object.assign(c, { lineWidth: 1, strokeStyle: look.line });
  for (const v of xTicks.values) { c.beginPath(); c.moveTo(X.at(v), top); c.lineTo(X.at(v), bottom); c.stroke(); }
  for (const v of yTicks.values) { c.beginPath(); c.moveTo(left, Y.at(v)); c.lineTo(right, Y.at(v)); c.stroke(); }
  Object.assign(c, { strokeStyle: look.grey, fillStyle: look.ink });
  c.beginPath();
  c.rect(left, top, right - left, bottom - top);
  c.stroke();
  Object.assign(c, { font: `${small}px system-ui, sans-serif`, textBaseline: "middle", textAlign: "right" });
  yTicks.values.forEach((v, i) => c.fillText(yTicks.texts[i], left - 0.35 * em, Y.at(v)));
  c.textAlign = "left";
  rTicks?.values.forEach((v, i) => c.fillText(rTicks.texts[i], right + 0.35 * em, R.at(v)));
  c.textAlign = "center";
  xTicks.values.forEach((v, i) => c.fillText(xTicks.texts[i], X.at(v), bottom + 0.8 * em));
  paintLabel(c, withPower(layout.xlabel, xTicks.power), (left + right) / 2, height - 0.8 * em, em, "center");
  for (const [label, x, ticks] of [[layout.ylabel, 0.8 * em, yTicks], [layout.label, width - 0.8 * em, rTicks]]) {
    if (!label) continue;
    c.save();
    c.translate(x, (top + bottom) / 2);
    c.rotate(-Math.PI / 2);
    paintLabel(c, withPower(label, ticks.power), 0, 0, em, "center");
    c.restore();
  }
  paintLegend(c, rows, Math.min(left, 2 * em), small, look);
}

// `fine` lines are quicker: for as long as a slider moves
function paintCurves(c, { X, Y, R, small, left, right, top, bottom, look }, { curves, note }, kept, fine = false) {
  c.save();
  c.beginPath();
  c.rect(left, top, right - left, bottom - top);
  c.clip();
  const side = { left: Y, right: R ?? Y, strip: new Axis([0, 1], [bottom, top]) };
  for (const curve of kept?.curves ?? []) if (curve.axis !== "strip") paintCurve(c, curve, X,
    side[curve.axis ?? "left"], look, true, fine);
  for (const curve of curves) paintCurve(c, curve, X, side[curve.axis ?? "left"], look, false, fine);
  c.restore();
  (note ? note.split("\n") : []).forEach((text, i) => {
    Object.assign(c, { font: `${small}px system-ui, sans-serif`, textBaseline: "middle", textAlign: "right" });
    const y = top + (0.9 + 1.3 * i) * small, wide = c.measureText(text).width;
    c.beginPath();
    c.rect(right - wide - 0.8 * small, y - 0.6 * small, wide + 0.6 * small, 1.2 * small);
    c.fillStyle = look.paper;
    c.fill();
    c.fillStyle = look.ink;
    c.fillText(text, right - 0.5 * small, y);
  });
}
