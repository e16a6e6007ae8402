// The engine of an exported page: the kernels in the browser.  A state gives a result, as panels and words take it.
const WINDOW_SAMPLES = 1500, DRAG_SAMPLES = 500, SPECTRUM_SAMPLES = 4096, REST_SAMPLES = 65, DECAY_SAMPLES = 400;
const DRAG_PATIENCE = 20, PATIENCE = 4000; // most milliseconds of a run, while a slider moves and when it has stopped
const MOST_NAMED = 8; // kinds of events; as in frictionlab/presentation.py
const PERIODS_SHOWN = 10, PERIODS_HEARD = 100;
const AT_REST = 1e-9, SEEN = 1e-3, AFTER_REST = 1.15, STEADY = 0.95; // as in frictionlab/widgets/result.py
const FRICTION_REACH = 1.1, FRICTION_SAMPLES = 200; // of a friction curve; as in frictionlab/widgets/front_end.py

class BrowserEngine {
  constructor(solver) { Object.assign(this, { solver, run: null, equilibrium: null }); }

  structureOf(state) { // undefined where the page has none: a law with some nonlinearities switched off
    const off = switchesOff(state), switched = SCENE.switches.filter((name) => off.includes(name)).join(",");
    const menu = SCENE.controls.find(({ name, kind }) => name === "friction" && kind === "choice"); // no parameter
    const law = menu && (state.friction ?? menu.value) !== menu.value ? `|${state.friction}` : "";
    return STRUCTURES[switched + law];
  }

  parametersOf(structure, state) { // in the order of the automaton's parameters
    const values = structure.parameters.map((name) => state[name] ?? structure.fixed[name]);
    if (structure.rate) values[structure.parameters.indexOf("chatter")] = chatterLimit(structure.rate(values)[0]);
    return values;
  }

  choose(name, changed = {}) { // another page of the folder
    const { page } = SCENE.menu.find((one) => one.name === name);
    location.href = `${page}#${linkText(changed, { initial: {}, controls: [] })}`;
  }

  has(name, state) { return this.structureOf(state)?.parameters.includes(name) ?? true; }

  ask(state, dragging, explorer) {
    try { explorer.show(this.compute(state, dragging), dragging);
    } catch (error) { explorer.fail(error.message, this.limits(state, explorer)); }
  }

  limits(state, { moved, result }) { // the last value of what was moved at which the rules of the model hold
    const structure = this.structureOf(state);
    if (!structure) return {};
    const values = this.parametersOf(structure, state), place = structure.parameters.indexOf(moved);
    const holds = (value) => !brokenRule(structure, values.map((v, i) => (i === place ? value : v)));
    const good = result?.parameters[moved];
    return place < 0 || !holds(good) || holds(values[place]) ? {} : { [moved]: lastValue(holds, good, values[place]) };
  }

  compute(state, dragging) { // the result; an error in words where there is none
    const structure = this.structureOf(state);
    if (!structure) throw new RangeError(`This page computes friction by the law "${state.friction}" only with `
      + "all nonlinearities on: switch them on, or take Python (fl.explore).");
    const values = this.parametersOf(structure, state), broken = brokenRule(structure, values);
    if (broken) throw new RangeError(broken);
    const [known, start] = this.startState(structure, values, state);
    const run = this.solver.run(structure, values, start, state.duration, dragging ? DRAG_PATIENCE : PATIENCE);
    this.run = run;
    return this.resultOf(run, known, state, dragging);
  }

  startState(structure, values, state) { // the equilibrium, or null, and the state in which the run begins
    const zero = structure.near.map(() => 0),
      last = this.equilibrium?.length === zero.length ? this.equilibrium : structure.near;
    const found = equilibriumOf(structure, values, [last, structure.near, zero]),
      known = found && found.sliding.following.length < zero.length ? found : null; // where something can move
    this.equilibrium = known ? known.z : null;
    const released = structure.release(values);
    if (state.start === "own") return [known, ownState(state.own, structure, released)];
    if (state.start === "rest") return [known, released];
    if (!known) throw new RangeError("there is no equilibrium to start near of: start from rest");
    return [known, displacedEquilibrium(known, values, shownStates(structure).length)];
  }

  resultOf(run, known, state, dragging) {
    const { structure } = run, [start, stop] = this.span(run, SCENE.windows[state.window]);
    const samples = sampleWithEvents(this.solver, run, start, stop, dragging ? DRAG_SAMPLES : WINDOW_SAMPLES);
    const shown = shownStates(structure), coordinate = shown.includes(state.coordinate) ? state.coordinate : shown[0];
    const facts = dragging ? {} : this.facts(run);
    return {
      structure, samples, start, stop, coordinate, from: state.start, highest: SCENE.highest,
        size: largest(shown.map(samples.column)),
      parameters: Object.fromEntries(structure.parameters.map((name, i) => [name, run.values[i]])),
      finished: run.status === FINISHED, status: this.statusText(run), mode: structure.modes[run.mode],
        final: run.state,
      struck: this.strikes(run, start), ...facts,
      spectrum: dragging ? undefined : this.spectrum(run, heardState({ structure, coordinate })),
      equilibrium: known && this.equilibriumData(known, run), eigenvalues: known && eigenvaluesAt(known, run.values),
      mechanism: structure.mechanism && mechanismAt(structure.mechanism, run.values),
      friction: structure.friction && this.frictionOf(known, run), complete: !dragging, drawings: {},
        milliseconds: run.milliseconds,
    };
  }

  statusText(run) {
    const end = shortNumber(run.end, 4), how = run.status === FINISHED ? "The end was reached"
      : run.status === RUNNING ? `Stopped at ${end} s: the run is long; take an earlier end`
      : `The run ended at ${end} s: ${SCENE.method.endings[run.status]}`;
    return `${how}. ${run.steps} steps, ${run.events} events${this.eventNames(run)}, `
      + `solved in ${run.milliseconds.toFixed(1)} ms`;
  }

  eventNames({ structure: { automaton, guards }, eventCodes, events }) { // " (2 land, 1 caught)" of an automaton
    const counts = new Map();
    for (let i = 0; automaton && i < events; i++) {
      const name = guards[Number(eventCodes[3 * i])];
      counts.set(name, (counts.get(name) ?? 0) + 1);
    }
    const texts = [...counts].sort(([, a], [, b]) => b - a).map(([name, count]) => `${count} ${name}`),
      more = texts.length > MOST_NAMED ? `, and ${texts.length - MOST_NAMED} more` : "";
    return texts.length ? ` (${texts.slice(0, MOST_NAMED).join(", ")}${more})` : "";
  }

  equilibriumData({ z, sliding }, { structure, values }) {
    const outputs = structure.outputs.functions[sliding.mode](z, values),
      of = (name) => outputs[structure.outputs.names.indexOf(name)] ?? NaN;
    return { state: z, penetration: of("penetration"), normal_force: of("normal_force"),
      friction_force: of("friction_force") };
  }

  strikes({ structure, eventTimes, eventCodes }, start) { // an event that is no period of a force in time
    return Array.from(eventTimes).some((t, i) => t > start && structure.guards[Number(eventCodes[3 * i])] !== "period");
  }

  frictionOf(known, { structure, values }) {
    const speeds = structure.points.filter(([speed]) => speed).map(([speed]) =>
      values[structure.parameters.indexOf(speed)]);
    const { names, functions } = structure.outputs, outputs = known && functions[known.sliding.mode](known.z, values);
    const one = known && names.includes("relative_velocity"); // several contacts of one law have speeds of their own
    const sliding = one ? { speed: Math.abs(outputs[names.indexOf("relative_velocity")]),
      normalForce: outputs[names.indexOf("normal_force")] } : null;
    return frictionCurve(structure.friction, Math.max(0, ...speeds), sliding, values);
  }

  coordinatesAt(run, times) { return shownStates(run.structure).map(sample(this.solver, run, times,
    NO_OUTPUTS).column); }

  isAtRest(run, start, stop) {
    const columns = this.coordinatesAt(run, sampleTimes(start, stop, REST_SAMPLES)),
      began = this.coordinatesAt(run, Float64Array.of(0));
    const size = Math.max(largest(columns), largest(columns.map((x, k) => x.map((v) => v - began[k][0]))));
    return spread(columns) <= AT_REST * size;
  }

  timeOfRest(run) { // from then on no coordinate visibly differs from its last value
    const times = sampleTimes(0, run.end, SAMPLES), columns = this.coordinatesAt(run, times);
    const away = times.map((_, i) => Math.max(...columns.map((x) => Math.abs(x[i] - x.at(-1))))),
      most = SEEN * largest([away]);
    return Math.max(times[Math.min(away.findLastIndex((v) => v > most) + 1, times.length - 1)],
      run.eventTimes.at(-1) ?? 0);
  }

  span(run, window) { // the part that is shown
    if (window === null) return [0, run.end];
    if (window === "beginning") return [0, Math.min(run.end, PERIODS_SHOWN * SCENE.period)];
    const seconds = window === "moving" ? PERIODS_SHOWN * SCENE.period : window, start = Math.max(0, run.end - seconds);
    if (window !== "moving" || !start || !this.isAtRest(run, start, run.end)) return [start, run.end];
    return [0, Math.min(run.end, AFTER_REST * this.timeOfRest(run))];
  }

  facts(run) {
    const seconds = PERIODS_SHOWN * SCENE.period, moving = !this.isAtRest(run, Math.max(0, run.end - seconds), run.end);
    const size = (end) => spread(this.coordinatesAt(run, sampleTimes(Math.max(0, end - seconds), end, DECAY_SAMPLES)));
    return { moving, rest: moving ? NaN : this.timeOfRest(run), decays: size(run.end) < STEADY * size(run.end / 2) };
  }

  spectrum(run, name) { // of the run's second half, or of the last periods
    const span = Math.min(run.end / 2, PERIODS_HEARD * SCENE.period);
    if (span * SCENE.highest < 5) return null;
    const signal = sample(this.solver, run, sampleTimes(run.end - span, run.end, SPECTRUM_SAMPLES),
      NO_OUTPUTS).column(name), step = span / (SPECTRUM_SAMPLES - 1);
    const found = amplitudes(signal), frequencies = Float64Array.from(found, (_, i) => i / (SPECTRUM_SAMPLES * step));
    const count = Math.max(8, frequencies.findIndex((f) => f > SCENE.highest)), shown = found.subarray(1, count),
      place = shown.indexOf(largest([shown]));
    return { frequencies: frequencies.subarray(1, count), amplitudes: shown, strongest: frequencies[1 + place],
      largest: shown[place] };
  }

  // from the dense output, not between samples
  instant(t) { return [sample(this.solver, this.run, Float64Array.of(t)), 0]; }

  hear() { // the end of the run: at most three seconds, played `pitch` times as fast as it happened
    const { run, solver } = this, { signal, pitch } = SCENE.sound, rate = 44100,
      count = Math.floor(Math.min(3, run.end / pitch) * rate), data = new Float32Array(Math.max(count, 1));
    for (let i = 0; i < count; i += SAMPLES) {
      const times = Float64Array.from({ length: Math.min(SAMPLES, count - i) },
        (_, k) => run.end - (count - i - k) / rate * pitch), found = sample(solver, run, times);
      data.set(found.byName[signal] ?? found.column(run.structure.states[run.structure.coordinates]), i);
    }
    const mean = data.reduce((a, b) => a + b, 0) / count,
      peak = data.reduce((a, b) => Math.max(a, Math.abs(b - mean)), 1e-300);
    const samples = data.map((v, i) => 0.9 * (v - mean) / peak * Math.min(1, i / 480, (count - i) / 480));
    return { samples, rate, text: `${signal.replace("_", " ")}, ${shortNumber(pitch, 3)} times as high as it is` };
  }

  python(state) { // between marks are the names of values
    const { python } = this.structureOf(state) ?? STRUCTURES[""];
    const start = state.start === "own" ? `[${ownState(state.own).map((v) => formatted(v)).join(", ")}]`
      : JSON.stringify(state.start);
    const value = (name) => (name === "start" ? start : formatted(state[name]));
    return python.split("\0").map((part, i) => (i % 2 ? value(part) : part)).join("");
  }
}

function ownState(text, structure = null, released = []) { // further states begin as at rest unless they are given
  const values = text.split(/[,;]/).filter((part) => part.trim()).map(Number);
  const refuse = (rule) => { throw new RangeError(`the own state must ${rule}`); };
  if (!values.every(Number.isFinite)) {
    refuse(`be numbers with commas between, got '${text}': write for example 0.01, 0, ...`);
  }
  if (!structure) return values;
  const { states, coordinates, automaton } = structure;
  if (!automaton && values.length === 2 * coordinates) return [...values, ...released.slice(2 * coordinates)];
  if (values.length !== states.length) {
    refuse(`have ${states.length} numbers, got ${values.length}: ${states.join(", ")}`);
  }
  return values;
}

function mechanismAt({ cases, numbers }, values) { // where a number depends on parameters, its place stands in a list
  const found = numbers(values);
  const filled = (each) => {
    if (Array.isArray(each)) return found[each[0]];
    if (typeof each !== "object") return each;
    if (each.text) return textOf(each.text, found);
    return Object.fromEntries(Object.entries(each).map(([name, field]) => [name, filled(field)]));
  };
  return caseOf(cases, found).parts.map(filled);
}

const caseOf = (cases, found) => cases.find(({ when }) => when.every((place) => found[place]));
const textOf = (parts, found) => parts.map((part) => (Array.isArray(part) ? formatted(found[part[0]], part[1]) : part))
  .join("");

function chatterLimit(rate) { // seconds, as hybrid/chatter_limit.py computes them
  return 0 < rate && rate < Infinity ? SCENE.method.chatter_share / rate : 0;
}

// The curve as data, as friction_data in front_end.py has it; `force` gives friction and its slope by speed and
// normal force.
function frictionCurve(force, last, sliding, values) {
  const { speed, normalForce } = sliding ?? { speed: 0, normalForce: 1 },
    reach = FRICTION_REACH * (Math.max(last, speed) || 1);
  const speeds = sampleTimes(0, reach, FRICTION_SAMPLES),
    mu = speeds.map((v) => force([v, normalForce], values)[0] / normalForce);
  if (!sliding) return { speeds, mu, at: null };
  const [friction, damper] = force([speed, normalForce], values);
  return { speeds, mu, at: [speed, friction / normalForce, damper / normalForce, damper] };
}

function lastValue(holds, good, bad) { // by bisection
  for (let middle = good + (bad - good) / 2; middle !== good && middle !== bad; middle = good + (bad - good) / 2) {
    if (holds(middle)) good = middle; else bad = middle;
  }
  return holds(roundNumber(good)) ? roundNumber(good) : good;
}

function brokenRule({ rules }, values) { // the model's message for the first rule that the parameters break, or null
  let found;
  try { found = rules.numbers(values); } catch { return null; } // a formula without a value here
  const broken = caseOf(rules.cases, found);
  return broken ? textOf(broken.message, found) : null;
}

function withExponent(text) { // as Python writes it
  const [number, power] = text.split("e");
  return `${number}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}

function halfToEven(write, digits) { // as Python rounds what is half-way; JavaScript rounds it away from zero
  const [number, power] = write(digits + 40).split("e"), head = number.slice(0, -40);
  const down = /^50*$/.test(number.slice(-40)) && /[02468]\.?$/.test(head);
  return down ? head.replace(/\.$/, "") + (power ? `e${power}` : "") : write(digits);
}

function formatted(v, format = "") { // as Python's formats "g", ".3g", ".2f", ".1e"; else all digits, as repr does
  const [, places = 6, kind] = format.match(/^(?:\.(\d+))?([efg])$/) ?? [], digits = Number(places), size = Math.abs(v);
  const exponential = (count) => halfToEven((d) => v.toExponential(d), count);
  if (kind === "f") return halfToEven((d) => v.toFixed(d), digits);
  if (kind === "e") return withExponent(exponential(digits));
  if (!kind) return size && (size < 1e-4 || size >= 1e16) ? withExponent(v.toExponential())
    : Number.isInteger(v) ? `${v}.0` : String(v);
  const shown = Math.max(digits, 1), text = exponential(shown - 1), rounded = Number(text);
  return size && (Math.abs(rounded) < 1e-4 || Math.abs(rounded) >= 10 ** shown)
    ? withExponent(text.replace(/\.?0+e/, "e")) : String(rounded);
}
