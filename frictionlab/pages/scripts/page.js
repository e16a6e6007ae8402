// The page: its controls, the run with their values, and the pictures of the run.
const PAGE_PACES = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002];
const WINDOW_SAMPLES = 1500, DRAG_SAMPLES = 400, SPECTRUM_SAMPLES = 4096;
const DRAG_PATIENCE = 40, PATIENCE = 4000; // most milliseconds of a run, while a slider moves and when it has stopped
const FRAME = 14; // milliseconds that solving and drawing may take while a slider moves; plots that do not fit are drawn in turns
const $ = (id) => document.getElementById(id);
const view = { solver: null, run: null, samples: null, picture: null, frames: null, time: 0, playing: null, last: null, request: null, settled: null, equilibrium: null, took: 0, turns: 1, turn: 0 };

function control(about) { // a slider with its number
  const { name, symbol, unit, meaning, low, high, log } = about;
  const to = (v) => log ? Math.log10(v) : v, from = (p) => Number((log ? 10 ** p : Number(p)).toPrecision(6));
  const range = html("input", { type: "range", id: `slider-${name}`, min: to(low), max: to(high), step: (to(high) - to(low)) / 400, ariaLabel: meaning || name });
  const number = html("input", { type: "number", id: `number-${name}`, step: "any", ariaLabel: `${meaning || name}, value` });
  const plain = symbol.replace(/\\mathrm\{(\w+)\}/g, "$1").replace(/\\([A-Za-z]+)/g, (_, letter) => ({ mu: "μ", Omega: "Ω", phi: "φ", alpha: "α", theta: "θ", zeta: "ζ", omega: "ω", beta: "β", gamma: "γ" })[letter] ?? letter).replace(/[{}]/g, "");
  const [letter, ...rest] = plain.split("_");
  const row = html("div", { className: "slider", id: `row-${name}`, title: `${meaning || name}${unit ? `, ${unit}` : ""} (${name})` },
    [html("label", { htmlFor: range.id }, [html("i", { textContent: letter }), ...(rest.length ? [html("sub", { textContent: rest.join("") })] : [])]), range, number]);
  range.oninput = () => { settings.values[name] = from(range.value); number.value = settings.values[name]; ask(true); };
  range.onchange = () => ask(false);
  number.onchange = () => { if (number.value !== "" && Number.isFinite(Number(number.value))) { settings.values[name] = Number(number.value); range.value = to(settings.values[name]); ask(false); } else number.value = settings.values[name]; };
  row.show = () => { range.value = to(settings.values[name]); number.value = settings.values[name]; };
  return row;
}

function build() {
  for (const about of SCENE.sliders) (about.open ? $("sliders") : $("others")).append(control(about));
  $("more").hidden = SCENE.sliders.every(({ open }) => open);
  for (const { name, about } of SCENE.switches) {
    const box = html("input", { type: "checkbox", id: `switch-${name}`, checked: true });
    box.onchange = () => { settings.off = SCENE.switches.map((s) => s.name).filter((s) => !$(`switch-${s}`).checked); ask(false); };
    $("switches").append(html("label", {}, [box, ` ${about}`]));
  }
  $("preset").append(html("option", { value: "", textContent: "as exported" }), ...SCENE.presets.map(({ name }, i) => html("option", { value: i, textContent: name })));
  $("preset").onchange = () => { const preset = SCENE.presets[$("preset").value]; resetSettings(); if (preset) { Object.assign(settings.values, preset.values); settings.off = preset.without; } showControls(); ask(false); };
  $("start").onchange = () => { settings.start = $("start").value; ask(false); };
  $("end").onchange = () => { const end = Number($("end").value); if (end > 0 && Number.isFinite(end)) settings.end = end; $("end").value = settings.end; ask(false); };
  const usual = roundDown125(SCENE.period / 2), paces = [...new Set([...PAGE_PACES, usual])].sort((a, b) => b - a);
  $("pace").append(...paces.map((p) => html("option", { value: p, textContent: p === 1 ? "real time" : p > 1 ? `${p} times faster` : `${+(1 / p).toPrecision(3)} times slower`, selected: p === usual })));
  $("window").onchange = () => redraw();
  $("play").onclick = togglePlay;
  $("scrub").oninput = () => { view.time = Number($("scrub").value) / 1000; showFrame(); };
  $("copy").onclick = () => copyText(pythonText(), "copied as Python");
  $("link").onclick = () => copyText(`${location.href.split("#")[0]}#${linkText()}`, "link copied");
  $("theme").onclick = () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  $("full").onclick = () => document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen?.();
  $("sound").onclick = playSound;
  onhashchange = () => { if (location.hash.slice(1) !== linkText()) { readLink(location.hash); showControls(); ask(false); } };
  onkeydown = (event) => {
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range" || event.ctrlKey || event.metaKey || event.altKey) return;
    const does = { " ": "play", c: "copy", l: "link", d: "theme", f: "full", s: "sound" }[event.key];
    if (does && !(event.key === " " && event.target.tagName === "BUTTON")) { event.preventDefault(); $(does).click(); }
  };
  let height = letters();
  new ResizeObserver(() => {
    if (letters() !== height && view.run) { height = letters(); redraw(); } // the plots in the new font size
    resizePlots(); drawPhase(); showFrame();
  }).observe(document.querySelector("main"));
}

function showControls() {
  for (const { name } of SCENE.sliders) $(`row-${name}`).show();
  for (const { name } of SCENE.switches) $(`switch-${name}`).checked = !settings.off.includes(name);
  $("start").value = settings.start;
  $("end").value = settings.end;
}

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  $("theme").textContent = name === "dark" ? "light" : "dark";
  forgetPlots();
  if (view.run) redraw();
}

async function copyText(text, said) {
  try { await navigator.clipboard.writeText(text); } catch { // a page opened from a file may not use the clipboard
    const area = html("textarea", { value: text });
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  view.copied = text;
  say(said);
}

const say = (text, bad = false) => { $("status").textContent = text; $("status").classList.toggle("bad", bad); };

function ask(dragging) { // at most one run per frame; a last one, with more time, when the slider has stopped
  clearTimeout(view.settled);
  if (dragging) view.settled = setTimeout(() => ask(false), 250);
  view.dragging = dragging;
  view.request ??= requestAnimationFrame(() => { view.request = null; compute(view.dragging); });
}

function startState(structure, values) {
  const known = equilibriumOf(structure, values, [view.equilibrium?.length === structure.states.length ? view.equilibrium : structure.near, structure.near, structure.near.map(() => 0)]);
  view.equilibrium = known ? known.z : null;
  const n = structure.coordinates, rest = structure.release(values);
  if (settings.start === "near" && !known) throw new RangeError("there is no equilibrium to start near of: start from rest");
  return [known, settings.start === "near" ? known.z.map((v, i) => i < n ? 1.01 * v : v) : rest];
}

function compute(dragging) {
  const began = performance.now(), structure = structureNow(), values = parametersOf(structure);
  try {
    const broken = brokenRule(structure, values);
    if (broken) throw new RangeError(broken);
    const [known, start] = startState(structure, values);
    view.run = view.solver.run(structure, values, start, settings.end, dragging ? DRAG_PATIENCE : PATIENCE);
    view.known = known;
    redraw(dragging);
    const { run } = view, how = run.status === RUNNING ? `stopped at ${run.end.toPrecision(4)} s: the run is long; take an earlier end` : STATUS[run.status];
    say(`${how[0].toUpperCase()}${how.slice(1)}. ${run.steps} steps, ${run.events} events; solved in ${run.milliseconds.toFixed(1)} ms, drawn in ${(performance.now() - began - run.milliseconds).toFixed(1)} ms`, run.status !== FINISHED);
    view.times = [run.milliseconds, performance.now() - began];
  } catch (error) { say(error.message, true); }
  for (const { name } of SCENE.sliders) $(`row-${name}`).classList.toggle("absent", !structure.parameters.includes(name));
  if (!dragging) try { history.replaceState(null, "", `#${linkText()}`); } catch { location.hash = linkText(); }
}

function redraw(dragging = false) { // all pictures of the run; while a slider moves only the quick ones, plots in turns if they take too long
  const { solver, run } = view, periods = Number($("window").value), end = run.end, span = periods ? Math.min(end, periods * SCENE.period) : end;
  view.start = end - span;
  view.span = span;
  view.samples = sample(solver, run, sampleTimes(view.start, end, dragging ? DRAG_SAMPLES : WINDOW_SAMPLES));
  const parameters = Object.fromEntries(run.structure.parameters.map((name, i) => [name, run.values[i]]));
  view.picture = pictureOf(run, view.samples, parameters);
  $("mechanism").hidden = !view.picture;
  for (const draw of dragging ? picturesInTurn() : PLOTS) draw();
  showFrame();
  showKey();
  if (dragging) return;
  showHeard(solver, run);
  showFinal();
}

const PLOTS = [() => showHistory(view.run, view.samples), () => drawPhase(), () => showForces(view.run, view.samples), () => showStability()];

function picturesInTurn() { // as many plots as fit into a frame, judged by the time of the last frame with all that the browser did
  const now = performance.now(), most = PLOTS.length;
  view.turns = Math.min(most, Math.max(1, view.turns + (view.took > FRAME ? -1 : 0.1)));
  setTimeout(() => { view.took = performance.now() - now + view.run.milliseconds; });
  return Array.from({ length: Math.floor(view.turns) }, () => PLOTS[view.turn = (view.turn + 1) % most]);
}

function showHeard(solver, run) { // the spectrum of the last hundred periods
  const span = Math.min(run.end, 100 * SCENE.period), times = sampleTimes(run.end - span, run.end, SPECTRUM_SAMPLES);
  showSpectrum(run, sample(solver, run, times, NO_OUTPUTS).column(run.structure.states[0]), span / (SPECTRUM_SAMPLES - 1));
}

function showStability() {
  const values = view.known ? eigenvaluesAt(view.known, view.run.values) : null;
  view.eigenvalues = values;
  if (!values) return showEigenvalues([], "eigenvalues: there is no sliding equilibrium");
  const growth = Math.max(...values.map(([re]) => re)), size = Math.max(...values.map(([re, im]) => Math.hypot(re, im)));
  const verdict = growth > 1e-12 * size ? "unstable" : growth < -1e-12 * size ? "stable" : "marginal";
  showEigenvalues(values, `eigenvalues: the equilibrium is ${verdict}, largest growth rate ${growth.toPrecision(4)}/s`);
}

function drawPhase() { // the curve; the marker of the present instant is on another canvas above it
  if (!view.samples || !$("phase").clientWidth) return;
  const [c, width, height] = fit($("phase")), states = view.run.structure.states, first = states[0];
  const scene = { axes: [first, `${written(first)} (${unitOf(first)})`, `${written(first + "'")} (${unitOf(first)}/s)`], line_colours: view.run.structure.colours, ink: theme().ink, letters: px(0.8) };
  view.place = phasePlane(c, width, height, scene, phaseFrames(view.run, view.samples));
}

function showKey() {
  const seen = [...new Set(view.samples.modes)].sort(), { modes, colours } = view.run.structure, key = JSON.stringify([modes, seen, view.picture?.note]);
  if (key === view.key) return;
  view.key = key;
  $("key").replaceChildren(...seen.map((mode) => { const s = html("span", { className: "mode", textContent: modes[mode] }); s.style.setProperty("--colour", colours[mode]); return s; }),
    ...(view.picture ? [html("span", { className: "mode", textContent: view.picture.note })] : []));
}

function showFinal() {
  const { run } = view;
  $("final").replaceChildren(...run.structure.states.map((name, i) => html("tr", {}, [html("td", { textContent: written(name) }), html("td", { className: "value", textContent: String(run.state[i]) })])));
}

function showFrame() { // the present instant, from the dense output rather than between samples
  const { run, picture, place } = view;
  if (!run) return;
  const t = Math.min(run.end, view.start + view.time * view.span), now = sample(view.solver, run, Float64Array.of(t));
  $("scrub").value = Math.round(1000 * view.time);
  $("now").textContent = `t = ${t.toFixed(4)} s: ${run.structure.modes[now.modes[0]]}`;
  if (picture && $("mechanism").clientWidth) {
    const [c, width, height] = fit($("mechanism"));
    picture.draw(c, width, height, picture.scene, picture.row(now, 0));
  }
  if (place && $("instant").clientWidth) {
    const [c] = fit($("instant")), first = run.structure.states[0];
    c.beginPath();
    c.arc(...place({ [first]: now.column(first)[0], rate: now.column(first + "'")[0] }), 6, 0, 7);
    Object.assign(c, { fillStyle: run.structure.colours[now.modes[0]], strokeStyle: theme().ink, lineWidth: 1.5 });
    c.fill();
    c.stroke();
  }
}

function togglePlay() {
  if (view.playing) { cancelAnimationFrame(view.playing); view.playing = view.last = null; } else view.playing = requestAnimationFrame(tick);
  $("play").textContent = view.playing ? "pause" : "play";
}

function tick(now) {
  if (view.last !== null) view.time = (view.time + (now - view.last) / 1000 * Number($("pace").value) / view.span) % 1;
  view.last = now;
  showFrame();
  view.playing = requestAnimationFrame(tick);
}

function playSound() { // the end of the run: at most three seconds, played `pitch` times as fast as it happened
  const { run, solver } = view, { signal, pitch } = SCENE.sound, context = new AudioContext(), rate = context.sampleRate;
  const seconds = Math.min(3, run.end / pitch), count = Math.floor(seconds * rate), buffer = context.createBuffer(1, Math.max(count, 1), rate), data = buffer.getChannelData(0);
  for (let i = 0; i < count; i += SAMPLES) {
    const part = Math.min(SAMPLES, count - i), times = Float64Array.from({ length: part }, (_, k) => run.end - (count - i - k) / rate * pitch);
    const found = sample(solver, run, times);
    data.set(found.byName[signal] ?? found.column(run.structure.states[run.structure.coordinates]), i);
  }
  const mean = data.reduce((a, b) => a + b, 0) / count, peak = data.reduce((a, b) => Math.max(a, Math.abs(b - mean)), 1e-300);
  for (let i = 0; i < count; i++) data[i] = 0.9 * (data[i] - mean) / peak * Math.min(1, i / 480, (count - i) / 480);
  const source = context.createBufferSource();
  source.buffer = buffer;
  source.connect(context.destination);
  source.start();
  view.heard = count;
}

async function begin() {
  document.documentElement.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  $("theme").textContent = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  $("about").textContent = `exact solver, in your browser; frictionlab ${SCENE.version}`;
  try { view.solver = await loadSolver(); } catch (error) { return say(`this browser cannot run the solver: ${error.message}`, true); }
  bindFunctions(view.solver);
  build();
  readLink(location.hash);
  showControls();
  const plays = settings.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches;
  compute(false);
  if (plays) togglePlay();
  document.body.dataset.ready = "yes";
  addEventListener("message", ({ data }) => { if (["light", "dark"].includes(data?.theme)) setTheme(data.theme); }); // from the page that embeds this one
  if (parent !== window) parent.postMessage("frictionlab page", "*");
}

begin();
