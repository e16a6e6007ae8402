// The state of a front end: a value for each control, by its name.  Earlier states; a state as a link, and as a file.
const SAME_MOVE = 700; // milliseconds: steps of one control that follow each other faster than this are undone together
const MOST_STATES = 200;
const FORMAT = "frictionlab explorer";
const LINK_WORDS = { start: "x0", duration: "t_end" }; // in links, the words of fl.simulate
// the word of a control in links, unless it is the name of a parameter
const linkWord = (name, { controls }) => (controls.some((about) => about.parameter && about.name === LINK_WORDS[name])
  ? name : LINK_WORDS[name] ?? name);
const sameValue = (a, b) => JSON.stringify(a) === JSON.stringify(b);

class StateHistory {
  constructor(first) { Object.assign(this, { states: [first], place: 0, moved: "", since: 0 }); }

  get present() { return this.states[this.place]; }

  record(state) { // a new one drops those that had been undone
    const now = performance.now(), changed = differences(this.present, state);
    if (!changed.length) return;
    const together = changed.length === 1 && changed[0] === this.moved && now - this.since < SAME_MOVE
      && this.place > 0;
    this.states.splice(this.place + (together ? 0 : 1));
    this.states = [...this.states, state].slice(-MOST_STATES);
    Object.assign(this, { place: this.states.length - 1, moved: changed.length === 1 ? changed[0] : "", since: now });
  }

  step(by) { // the state before or after, or null
    if (!this.states[this.place + by]) return null;
    this.place += by;
    this.moved = "";
    return this.present;
  }
}

// what differs from the beginning, and what is asked or told
function linkText(state, scene, { challenge = null, lesson = null } = {}) {
  const changed = differences(scene.initial, state), parts = scene.name ? [["scene", scene.name]] : [];
  if (challenge) parts.push(["challenge", challenge.name]);
  if (lesson?.steps.length && !lesson.recording) parts.push(["lesson", JSON.stringify(lesson.steps)],
    ["step", String(lesson.place + 1)]);
  const isParameter = (name) => scene.controls.some((about) => about.name === name && about.parameter),
    add = (name) => parts.push([linkWord(name, scene), String(state[name])]);
  changed.filter(isParameter).forEach(add);
  if (changed.some(isSwitch)) parts.push(["without", switchesOff(state).join(",")]);
  changed.filter((name) => !isParameter(name) && !isSwitch(name)).forEach(add);
  return String(new URLSearchParams(parts)).replaceAll("%2C", ","); // commas need no code, and are easier to read
}

const isSwitch = (name) => name.startsWith("switch-");
const switchesOff = (state) => Object.keys(state).filter((name) => isSwitch(name)
  && !state[name]).map((name) => name.slice("switch-".length));

// {state, scene, plays, challenge, steps, step}; what no control can be set to is left out
function readLink(text, scene) {
  const given = new URLSearchParams(text.replace(/^#/, "")), state = { ...scene.initial };
  const off = given.get("without")?.split(",").map((name) => `switch-${name}`);
  for (const { name, kind, options } of scene.controls) {
    const value = given.get(linkWord(name, scene)) ?? given.get(name), number = Number(value);
    if (kind === "switch") state[name] = off ? !off.includes(name) : state[name];
    else if (value === null) continue;
    else if (kind === "range") state[name] = value.split(",").map(Number);
    else if (kind !== "number") state[name] = kind !== "choice" || options.includes(value) ? value : state[name];
    else if (value !== "" && Number.isFinite(number) && (name !== "duration" || number > 0)) state[name] = number;
  }
  let steps = [];
  try { steps = lessonSteps(JSON.parse(given.get("lesson")), scene); } catch {} // it is none
  return { state, steps, step: Math.max(0, Number.parseInt(given.get("step"), 10) - 1 || 0),
    scene: given.get("scene") ?? "",
    challenge: scene.challenges.find(({ name }) => name === given.get("challenge")) ?? null,
    plays: given.get("play") === "1" }; // as soon as it is loaded, for pages embedded in others
}

function stateText(state, scene) {
  return JSON.stringify({ format: FORMAT, model: scene.model, scene: scene.name ?? "",
    changed: changedValues(state, scene) }, null, 1);
}

function stateFromText(text) { // {model, scene, changed}, or {model, scene, steps} of a lesson
  let data;
  try { data = JSON.parse(text); } catch { data = null; }
  const known = data?.format && (data.changed ?? data.steps);
  if (!known) throw new RangeError("the file must be one that an explorer saved");
  if (data.format !== (data.steps ? LESSON_FORMAT : FORMAT)) {
    throw new RangeError(`the file must be one that an explorer saved, got the format '${data.format}'`);
  }
  return data;
}

function csvText({ structure, samples }) { // a line of names, then one for each time; numbers have all their digits
  const columns = Object.keys(samples.byName).filter((name) => name !== "t"), values = columns.map(samples.column);
  const lines = Array.from(samples.times,
    (t, i) => [t, ...values.map((v) => v[i]), structure.modes[samples.modes[i]]].join(","));
  return [["t", ...columns, "mode"].join(","), ...lines, ""].join("\n");
}
