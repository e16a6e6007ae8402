// The friction curve: coefficient over speed, its slope at the speed of steady sliding, points that are dragged, and a
// formula that puts them on its curve.
const DRAG = "drag the points", EXAMPLE = "0.3 + 0.1*exp(-abs(v)/0.2)";
const NEAREST_POINTS = 0.01; // share of the speeds that are shown, by which two points stay apart

const withMinus = (v) => shortNumber(v, 3).replace(/^-/, "−");

const FUNCTIONS = ["exp", "log", "sqrt", "abs", "sin", "cos", "tan", "tanh", "atan"];
const NUMBERS = { pi: Math.PI, e: Math.E };
const SIGN_RANK = 3, POWER_RANK = 4;
/** @type {Map<string, any[]>} */
const OPERATORS = new Map([["+", [1, (a, b) => a + b]], ["-", [1, (a, b) => a - b]], ["*", [2, (a, b) => a * b]],
  ["/", [2, (a, b) => a / b]], ["^", [POWER_RANK, (a, b) => a ** b]], ["**", [POWER_RANK, (a, b) => a ** b]]]);

// A text such as "0.3 + 0.1*exp(-abs(v)/0.2)" as a function of v; an error in words where it is none. Names other than
// those above mean nothing, so that no text can do more than compute.
function readFormula(text) {
  const parts = text.match(/\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?|[a-z]\w*|\*\*|\S/gi) ?? [];
  let at = 0;
  const fail = (rule) => { throw new RangeError(`the formula must ${rule}: write for example ${EXAMPLE}`); };
  const said = () => (at < parts.length ? `'${parts[at]}'` : "its end"), next = (...some) =>
    (some.includes(parts[at]) ? parts[at++] : null);
  function sum(least = 1) { // of operands between which stand operators of this rank at least
    let left = operand();
    for (;;) {
      const [rank, compute] = OPERATORS.get(parts[at]) ?? [0];
      if (rank < least) return left;
      at += 1;
      const before = left, after = sum(rank === POWER_RANK ? SIGN_RANK : rank + 1);
      left = (v) => compute(before(v), after(v));
    }
  }
  function operand() {
    if (next("+")) return sum(SIGN_RANK);
    if (next("-")) { const inner = sum(SIGN_RANK); return (v) => -inner(v); }
    const part = parts[at] ?? "";
    if (/^[\d.]/.test(part) && Number.isFinite(Number(part))) { at += 1; return () => Number(part); }
    if (next("(")) return closed();
    if (!/^[a-z]/i.test(part)) fail(`have a number, v, a function or a bracket where it has ${said()}`);
    at += 1;
    if (part === "v") return (v) => v;
    if (Object.hasOwn(NUMBERS, part)) return () => NUMBERS[part];
    if (!FUNCTIONS.includes(part)) fail(`have no name but v, pi, e, ${FUNCTIONS.join(", ")}, got '${part}'`);
    if (!next("(")) fail(`have a bracket after ${part}, where it has ${said()}`);
    const inner = closed();
    return (v) => Math[part](inner(v));
  }
  function closed() {
    const inner = sum();
    if (!next(")")) fail(`close a bracket where it has ${said()}`);
    return inner;
  }
  const whole = sum();
  if (at < parts.length) fail(`have an operation where it has ${said()}`);
  return whole;
}

function pointsOnFormula(text, points, parameters) { // values of the coefficients, at the speeds of the points
  const mu = readFormula(text);
  return Object.fromEntries(points.map(([speed, coefficient]) => {
    const v = speed ? parameters[speed] : 0, value = mu(v);
    if (!Number.isFinite(value)) throw new RangeError(`the formula must have a number at each point, none at v = ${v}`);
    return [coefficient, roundNumber(value, 4)];
  }));
}

// its curve, and words on its slope at a speed and on what the points, up to the last one, miss of it
function formulaDrawing(text, speeds, mu, v, last, unit) {
  const of = readFormula(text), y = Float64Array.from(speeds, of), step = 1e-5 * speeds.at(-1);
  const slope = v === undefined ? null : (of(v + step) - of(v - step)) / (2 * step);
  const missed = mu.map((value, i) => (speeds[i] > last ? 0 : value - y[i]));
  const said = slope === null ? "" : `formula: slope ${withMinus(slope)} ${unit.split("/").reverse().join("/")}\n`;
  return { curve: { label: "formula", x: speeds, y, colour: "#009E73", dash: DASHED, width: 1.5 },
    note: `${said}points within ${shortNumber(largest([missed]), 2)} of it` };
}

// null where nothing varies
function frictionDrawing(result, { formula = "" } = {}) {
  const { friction, parameters, structure: { points, sliding_units: units } } = result;
  if (!friction || !points.length && spread([friction.mu]) < SILENT) return null;
  const { speeds, mu, at } = friction, reach = speeds.at(-1),
    curves = /** @type {any[]} */ ([{ label: "_friction", x: speeds, y: mu, width: 2 }]);
  const handles = points.map(([speed, coefficient]) =>
    ({ x: speed ? parameters[speed] : 0, y: parameters[coefficient], speed, coefficient }));
  let note = handles.length ? DRAG : "";
  if (at) {
    const [v, here, slope, damper] = at, ends = [Math.max(0, v - 0.25 * reach), Math.min(reach, v + 0.25 * reach)];
    curves.push({ label: `slope at ${steadyMotion(result)}`, x: ends, y: ends.map((u) => here + slope * (u - v)),
      colour: "#D55E00", dash: DASHED });
    const like = Math.abs(slope) * v < SILENT * here ? "no damper" : `a damper of ${withMinus(damper)} ${units.damper}`;
    note = `${shortNumber(v, 3)} ${units.speed}: like ${like}\n${note}`.trim();
  }
  if (handles.length && formula) {
    const drawn = formulaDrawing(formula, speeds, mu, at?.[0], handles.at(-1).x, units.speed);
    curves.push(drawn.curve);
    note = `${note.replace(DRAG, "")}${drawn.note}`;
  }
  if (handles.length) curves.push({ label: "_points", x: handles.map(({ x }) => x), y: handles.map(({ y }) => y),
    colour: "#0072B2", marker: "o", size: 13, line: false });
  const top = Math.max(largest([mu]), ...handles.map(({ y }) => y)) || 1;
  return { xlabel: withUnit("sliding speed", units.speed), ylabel: "coefficient of friction", curves, note, handles,
    xlim: [0, reach], ylim: [0, roundStep(1.25 * top)] };
}

function letDragPoints(explorer, panel) { // of the curve; the parameters follow, and with them motion and stability
  const { over } = panel;
  let held; // on the axes on which it was taken: those that are drawn follow the curve
  const find = ({ clientX, clientY }) => { // what is needed of the point under a pointer
    const { drawing, axes } = panel, box = over.getBoundingClientRect();
    if (!drawing?.handles || !axes) return null;
    const away = drawing.handles.map(({ x, y }) =>
      Math.hypot(axes.X.at(x) - clientX + box.left, axes.Y.at(y) - clientY + box.top));
    const place = away.indexOf(Math.min(...away));
    return away[place] <= FINGER ? { place, axes, handles: drawing.handles } : null;
  };
  const pull = (event, dragging) => {
    const { place, axes: { X, Y }, handles } = held, box = over.getBoundingClientRect(),
      apart = NEAREST_POINTS * X.high;
    const between = (low, value, high) => roundNumber(Math.min(Math.max(value, low), high), 4);
    const { speed, coefficient } = handles[place], right = handles[place + 1]?.x ?? Infinity;
    const moved = { [coefficient]: between(0, Y.value(event.clientY - box.top), Infinity) };
    if (speed) moved[speed] = between(handles[place - 1].x + apart, X.value(event.clientX - box.left), right - apart);
    explorer.changeAll({ ...moved, formula: "" }, dragging, true);
  };
  letDrag(over, find, { grip: (found) => { held = found; }, pull: (event) => pull(event, true),
    release: (event) => pull(event, false), cancel: () => {} });
}
