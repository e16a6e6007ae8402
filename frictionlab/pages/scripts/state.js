// The settings of the page: parameters, switches, start and end; their text as a link and as Python.
const settings = { values: {}, off: [], start: "rest", end: SCENE.t_end, plays: false };

function resetSettings() {
  settings.values = Object.fromEntries(SCENE.sliders.map(({ name, value }) => [name, value]));
  Object.assign(settings, { off: [], start: "rest", end: SCENE.t_end });
}

const structureNow = () => STRUCTURES[SCENE.switches.map(({ name }) => name).filter((name) => settings.off.includes(name)).join(",")];

function parametersOf(structure) { // in the order of the automaton's parameters
  const values = structure.parameters.map((name) => settings.values[name] ?? structure.fixed[name]);
  const chatter = structure.parameters.indexOf("chatter");
  if (structure.rate) values[chatter] = chatterLimit(structure.rate(values)[0]);
  return values;
}

function chatterLimit(rate) { // seconds, as hybrid/chatter_limit.py computes them
  return 0 < rate && rate < Infinity ? SCENE.method.chatter_share / rate : 0;
}

function linkText() {
  const parts = SCENE.sliders.filter(({ name, value }) => settings.values[name] !== value).map(({ name }) => `${encodeURIComponent(name)}=${settings.values[name]}`);
  if (settings.off.length) parts.push(`without=${settings.off.join(",")}`);
  if (settings.start !== "rest") parts.push(`x0=${settings.start}`);
  if (settings.end !== SCENE.t_end) parts.push(`t_end=${settings.end}`);
  return parts.join("&");
}

function readLink(text) {
  resetSettings();
  settings.plays = false;
  for (const [name, value] of new URLSearchParams(text.replace(/^#/, ""))) {
    if (name === "without") settings.off = SCENE.switches.map((s) => s.name).filter((s) => value.split(",").includes(s));
    else if (name === "x0") settings.start = value === "near" ? "near" : "rest";
    else if (name === "play") settings.plays = value === "1"; // it plays as soon as it is loaded, for pages embedded in others
    else if (name === "t_end") settings.end = Number(value) > 0 && Number.isFinite(Number(value)) ? Number(value) : SCENE.t_end;
    else if (name in settings.values && value !== "" && Number.isFinite(Number(value))) settings.values[name] = Number(value);
  }
}

function brokenRule({ rules }, values) { // the model's message for the first rule that the parameters break, or null
  let found, at = 0;
  try { found = rules.numbers(values); } catch { return null; } // a formula without a value here
  for (const { relations, values: count, message } of rules.words) {
    const broken = found.slice(at, at + relations).every(Boolean), shown = found.slice(at + relations, at + relations + count);
    at += relations + count;
    if (broken) return message.map((part, i) => i % 2 ? formatted(shown[(i - 1) / 2], part) : part).join("");
  }
  return null;
}

function withExponent(v, digits) { // as Python writes it
  const [number, power] = v.toExponential(digits).split("e");
  return `${digits === undefined ? number : +number}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}

function formatted(v, format) { // as Python's format "g" writes it; else all digits, as repr does
  const size = Math.abs(v);
  if (format !== "g") return size && (size < 1e-4 || size >= 1e16) ? withExponent(v) : Number.isInteger(v) ? `${v}.0` : String(v);
  const rounded = Number(v.toPrecision(6));
  return size && (Math.abs(rounded) < 1e-4 || Math.abs(rounded) >= 1e6) ? withExponent(v, 5) : String(rounded);
}

function pythonText() {
  const present = structureNow().parameters, number = formatted;
  const values = SCENE.sliders.filter(({ name }) => present.includes(name)).map(({ name }) => `${name}=${number(settings.values[name])}`);
  const off = settings.off.length ? `.without(${settings.off.map((name) => `"${name}"`).join(", ")})` : "";
  const replaced = off ? `${SCENE.call}()${off}.replace(${values.join(", ")})` : `${SCENE.call}(${values.join(", ")})`;
  return `import frictionlab as fl\n\nmodel = ${replaced}\nrun = fl.simulate(model, ${number(settings.end)}, x0="${settings.start}")\nprint(run.final_state.tolist())\n`;
}
