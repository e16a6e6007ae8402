// The panels that have names: functions of a result that return a drawing, or null where they have nothing to show.
//
// A result is what an engine computes: {structure, samples, start, stop, equilibrium, eigenvalues, spectrum, ...}.
// Its structure names states, modes and outputs, with labels, units and colours; its samples are arrays of the part
// that is shown.
const DASHED = [4, 1.5]; // lengths of dashes and gaps, in widths of the line; as in frictionlab/plotting/appearance.py
const PALETTE = ["#000000", "#D55E00", "#0072B2", "#009E73", "#E69F00", "#CC79A7"];
const GREY = "#999999", ROUNDING = 1e-12; // share of an eigenvalue's size below which its real part is a rounding error
const LEAST_BAND = 0.1; // of frequencies that are shown, as share of the highest
const SILENT = 1e-9; // share of a motion's size below which an amplitude is rounding

// of the array that varies most
const spread = (columns) => Math.max(...columns.map((x) =>
  x.reduce((a, b) => Math.max(a, b)) - x.reduce((a, b) => Math.min(a, b))));

function samplesByName(times, modes, names, columns) {
  const byName = Object.fromEntries(names.map((name, i) => [name, columns[i]]));
  return { times, modes, byName, column: (name) => byName[name] };
}

const isAngle = (result, name) => result.structure.units[name].startsWith("rad");
const steadyMotion = ({ structure: { slides, cyclic, units } }) => (!slides ? "the equilibrium"
  : cyclic.some((name) => units[name] === "rad") ? "steady rotation" : "steady sliding");
// whose spectrum is shown: of an angle that turns for ever the rate
const heardState = ({ structure: { cyclic, rates }, coordinate: name }) => (cyclic.includes(name) ? rates[name] : name);
const withUnit = (label, unit) => (unit ? `${label} (${unit})` : label); // states of an automaton have none
const axisLabel = ({ structure: { labels, units } }, name) => withUnit(labels[name], units[name]);
// the coordinates, or all states where there are none
const shownStates = ({ states, coordinates }) => states.slice(0, coordinates || states.length);

// the state against which one is drawn in the phase plane: its rate or, without coordinates, the next one
function otherState({ states, coordinates, rates }, name) {
  return coordinates ? rates[name] : states.length > 1 ? states[(states.indexOf(name) + 1) % states.length] : null;
}

// a curve for each mode that occurs, up to the sample after
function curvesByMode({ structure, samples: { modes } }, x, y, look) {
  return wholeModes(structure, modes).map(({ label, colour, dash, members }) => {
    const shown = (i) => members.has(modes[i]) || i > 0 && members.has(modes[i - 1]);
    return { label, x, y: Float64Array.from(y, (v, i) => (shown(i) ? v : NaN)), colour, dash, ...look };
  });
}

function wholeModes(structure, modes) { // the modes that occur; those that a law in pieces splits are one again
  const wholes = new Map();
  for (const mode of [...new Set(modes)].sort((a, b) => a - b)) {
    const key = structure.wholes[mode];
    if (wholes.has(key)) Object.assign(wholes.get(key), { label: key }).members.add(mode);
    else wholes.set(key, { label: structure.modes[mode], colour: structure.colours[mode], dash: structure.dashes[mode],
      members: new Set([mode]) });
  }
  return [...wholes.values()];
}

function modeStrip(result) {
  const { times } = result.samples;
  return curvesByMode(result, times, new Float64Array(times.length).fill(0.02), { width: 7, axis: "strip" });
}

function coordinateCurves(result, names) {
  const mixed = names.some((name) => isAngle(result, name)) && !names.every((name) => isAngle(result, name));
  return names.map((name, i) => {
    const angle = isAngle(result, name), axis = mixed && angle ? "right" : "left";
    const colour = PALETTE[i % PALETTE.length], dash = mixed && angle || i >= PALETTE.length ? DASHED : [];
    const turns = doesTurn(result, name), { times, column } = result.samples,
      [y, x] = turns ? cutAtTurns(column(name), times) : [column(name), times];
    return { label: result.structure.labels[name], x, y, colour, dash, axis, turns };
  });
}

function historyDrawing(result, names, words) {
  const curves = coordinateCurves(result, names),
    units = [...new Set(names.map((name) => result.structure.units[name]))];
  const left = names.find((_, i) => curves[i].axis === "left"),
    right = names.find((_, i) => curves[i].axis === "right");
  const word = (name) => (result.structure.automaton ? names.length > 1 ? words[2] : result.structure.labels[name]
    : words[isAngle(result, name) ? 1 : 0]);
  const label = (name, dashed) =>
    (name ? `${withUnit(word(name), result.structure.units[name])}${dashed ? ", dashed" : ""}` : "");
  const turns = (axis) => curves.every((curve) => curve.axis !== axis || curve.turns);
  return { xlabel: "time (s)", ylabel: label(left), right: units.length > 1 ? label(right, true) : "", curves,
    xlim: [result.start, result.stop], turns: { left: turns("left"), right: turns("right") },
    note: noteOfTurns(result, names) };
}

function response(result) {
  const drawing = historyDrawing(result, shownStates(result.structure), ["displacement", "angle", "state"]);
  return { ...drawing, curves: [...drawing.curves,
    ...modeStrip(result).map((curve) => ({ ...curve, label: `_${curve.label}` }))] };
}

function forces(result) {
  const { structure: { forces: drawn }, samples: { times, column } } = result,
    names = Object.keys(drawn).filter(column);
  if (!names.length) { // the rates, where a model has no contact forces
    const { coordinates, rates, automaton } = result.structure;
    if (!coordinates) return null;
    const drawing = historyDrawing(result, Object.values(rates), ["velocity", "angular velocity", "rate"]);
    return { ...drawing, title: automaton ? "rates" : "velocities", curves: [...drawing.curves, ...modeStrip(result)] };
  }
  const curves = names.map((name) => ({ label: drawn[name][0], x: times, y: column(name), colour: drawn[name][1] }));
  const ylabel = result.structure.axis_of_forces, title = ylabel.replace(/ \([^)]*\)/g, "s");
  return { title, xlabel: "time (s)", ylabel, curves: [...curves, ...modeStrip(result)],
    xlim: [result.start, result.stop] };
}

function phase(result) {
  const name = result.coordinate, { samples: { column }, structure, equilibrium } = result,
    other = otherState(structure, name), turns = { x: doesTurn(result, name) };
  if (!other) return null;
  const curves = curvesByMode(result, column(name), column(other), {}).map((curve) => {
    if (!turns.x) return curve;
    const [x, y] = cutAtTurns(curve.x, curve.y);
    return { ...curve, x, y };
  });
  if (equilibrium && !structure.cyclic.includes(name)) {
    const [x, y] = [name, other].map((one) => [equilibrium.state[structure.states.indexOf(one)]]);
    curves.push({ label: "equilibrium", x, y, marker: "+", size: 11, line: false });
  }
  return { xlabel: axisLabel(result, name), ylabel: axisLabel(result, other), curves, turns,
    note: noteOfTurns(result, [name]), touch: (x, v) => ({ [name]: x, [other]: v }) };
}

function spectrum(result) {
  const name = heardState(result), xlim = [0, result.highest];
  const about = { xlabel: "frequency (Hz)", ylabel: `amplitude of ${axisLabel(result, name)}`, log: true, xlim };
  const found = result.spectrum;
  if (!found) return { ...about, curves: [], note: "the run is too short for a spectrum" };
  if (!(found.largest > SILENT * result.size)) return { ...about, curves: [], note: "at rest" };
  const curve = { label: "_spectrum", x: found.frequencies, y: found.amplitudes, width: 1 };
  return { ...about, curves: [curve], note: `strongest line ${shortNumber(found.strongest, 4)} Hz` };
}

function eigenvaluePanel(result) {
  if (!result.eigenvalues) return null; // the words say why there are none
  const upper = result.eigenvalues.filter(([, im]) => im >= 0),
    neutral = upper.every(([re, im]) => Math.abs(re) <= ROUNDING * Math.hypot(re, im));
  const grows = ([re, im]) => re > ROUNDING * Math.hypot(re, im),
    some = (chosen, label, look) =>
    ({ label, x: chosen.map(([re]) => re), y: chosen.map(([, im]) => im / (2 * Math.PI)), line: false, size: 8,
    ...look });
  const curves = [
    { label: "_no growth", x: [0, 0], y: [0, 1], colour: GREY, width: 1, axis: "strip" },
    some(upper.filter((value) => !grows(value)), "decays or lasts", { colour: "#0072B2", marker: "o" }),
    some(upper.filter(grows), "grows", { colour: "#D55E00", marker: "^" }),
  ];
  const title = `eigenvalues of ${steadyMotion(result)}`;
  return { title, xlabel: "growth rate (1/s)", ylabel: "frequency (Hz)", curves, least: LEAST_BAND,
    ...(neutral ? { xlim: [-1, 1] } : {}) };
}

const PANELS = { // `instant`: how the instant is marked in it; `ofCoordinate`: it shows the one that is chosen
  mechanism: { title: "mechanism" },
  response: { title: "time history", draw: response, instant: "line" },
  phase: { title: "phase plane", draw: phase, instant: "dot", ofCoordinate: true },
  forces: { title: "contact forces", draw: forces, instant: "line" },
  spectrum: { title: "spectrum", draw: spectrum, ofCoordinate: true },
  eigenvalues: { title: "eigenvalues of steady sliding", draw: eigenvaluePanel },
  friction: { title: "friction curve", draw: frictionDrawing },
};
