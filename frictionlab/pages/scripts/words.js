// What a result says in words: whether steady sliding is stable, what the run does, why it ended.
const VERBS = { stick: "sticks", "slip+": "slips", "slip-": "slips", slip: "slips", separation: "separates" };
const STARTS = { rest: "from rest", near: "from near the equilibrium", own: "from your own state" };
const NOTHING_SLIDES = "Nothing in this model slides while its coordinates rest, so there is no steady sliding to be "
  + "stable or unstable.";
const QUIET = /falls silent$|dies away$/;
const CLOCKS = ["t", "phase"]; // states that stand for time
const DRIVEN = "There is no steady sliding, as what moves the bodies changes with time.";
const MOST_PLACES = 12; // of an equilibrium in words
const NO_EQUILIBRIUM = "No equilibrium was found.";
const NOT_FOUND = "No equilibrium in which something slides was found.";
const sentence = (text) => text && text[0].toUpperCase() + text.slice(1);

function verdict(result) {
  const happens = runText(result), values = result.eigenvalues;
  if (!values) {
    const { automaton, slides, states } = result.structure, driven = states.some((name) => CLOCKS.includes(name));
    const why = automaton ? NO_EQUILIBRIUM : !slides ? NOTHING_SLIDES : driven ? DRIVEN : NOT_FOUND;
    return `${why}${happens ? ` ${sentence(happens)}.` : ""}`;
  }
  const text = stabilityText(values), joint = text === "stable" && !QUIET.test(happens) ? "but" : "and";
  return `${sentence(steadyMotion(result))} is ${text}${happens ? `, ${joint} ${happens}` : ""}.`;
}

function stabilityText(values) {
  const upper = values.filter(([, im]) => im >= 0), share = ([re, im]) => re / (Math.hypot(re, im) || 1);
  const growing = upper.filter((value) => share(value) > ROUNDING).sort((a, b) => b[0] - a[0]);
  if (!growing.length) return upper.every((value) => share(value) < -ROUNDING) ? "stable"
    : "neither stable nor unstable: a mode neither grows nor decays";
  const [re, im] = growing[0], modes = growing.length === 1 ? "1 mode grows" : `${growing.length} modes grow`;
  return `unstable: ${modes}, at ${shortNumber(re, 4)} 1/s and ${shortNumber(im / (2 * Math.PI), 4)} Hz`;
}

function runText(result) { // a clause: what the run does at its end
  if (!result.samples || !result.finished) return "";
  const { automaton } = result.structure, from = automaton && result.from === "rest" ? "from zero"
    : STARTS[result.from];
  if (!result.moving) return result.mode.includes("slip") ? `${from} this run falls silent`
    : `${from} this run is over after ${shortNumber(result.rest, 3)} s`;
  const what = motionText(result);
  if (!what && result.decays) return `${from} this run dies away`;
  const { largest, strongest } = result.spectrum ?? {},
    pitch = largest > SILENT * result.size ? ` at ${shortNumber(strongest, 3)} Hz` : "";
  return `${from} this run ${what || (automaton ? "goes on" : "vibrates")}${pitch}`;
}

function motionText({ structure, samples, struck }) { // as its modes tell; empty where they tell nothing
  const regimes = new Set([...new Set(samples.modes)].flatMap((mode) => structure.modes[mode].split(" | ")));
  if (regimes.size === 1 && regimes.has("flight")) return struck && !structure.automaton ? "hits its stop" : "";
  const verbs = [...new Set(Object.keys(VERBS).filter((regime) => regimes.has(regime)).map((regime) => VERBS[regime]))];
  if (verbs.length > 1) return `${verbs.slice(0, -1).join(", ")} and ${verbs.at(-1)}`;
  return regimes.has("slip+") && regimes.has("slip-") ? "slips to and fro" : "";
}

// "x1 = 0.15 m" ..., with LaTeX; the rate of what turns steadily; further states, but for time
function equilibriumTexts({ structure, equilibrium }) {
  if (!equilibrium) return [];
  const { states, labels, units, coordinates: n } = structure, { state } = equilibrium;
  const shown = states.map((_, i) => (i < n ? !state[i + n] : i < 2 * n ? state[i] : !CLOCKS.includes(states[i])));
  const text = ([label, value, unit]) => `${label} = ${shortNumber(value)} ${unit}`.trim();
  const known = (rows) => rows.filter(([, value]) => Number.isFinite(value)).map(text);
  const texts = known(states.map((name, i) => [labels[name], state[i], units[name]]).filter((_, i) => shown[i]));
  if (texts.length > MOST_PLACES) texts.push(`and ${texts.splice(MOST_PLACES).length} more`);
  const forces = Object.entries(structure.at_contact).map(([name, [label, unit]]) => [label, equilibrium[name], unit]);
  return [...texts, ...known(forces)];
}

function differences(before, now) { // names of the controls that two states do not share
  return Object.keys({ ...before, ...now }).filter((name) =>
    JSON.stringify(before[name]) !== JSON.stringify(now[name]));
}

const shownValue = (value) => (value === true ? "on" : value === false ? "off" : typeof value === "number"
  ? shortNumber(value, 7) : String(value));
