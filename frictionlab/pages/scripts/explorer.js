// The front end: controls, panels and words of one scene, whose results an engine computes.
//
// An engine has ask(state, dragging, explorer), which comes back with explorer.show(result) or explorer.fail(text),
// now or later; instant(t), the samples of an instant and its place in them; has(name, state), whether the model has
// a parameter; python(state), the code that computes the same; hear(explorer), what the run sounds like. One that
// computes while the page lives has stop(explorer).
const PACES = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002];
const BUSY_AFTER = 300; // milliseconds
const MOST_COMPARED = 2; // coordinates of two scenes in one panel
const GROUPS = { main: "", structure: "more parameters", run: "how it is run and shown" };
const paceText = (pace) => (pace === 1 ? "real time" : pace > 1 ? `${shortNumber(pace, 3)} times faster`
  : `${shortNumber(1 / pace, 3)} times slower`);

const PARTS = ["title", "about", "files", "side", "status", "busy", "words", "numbers", "comparison", "pictures",
  "scrub", "pace", "now", "heard", "modes"]; // of explorer.html, by their classes
const ACTIONS = { // of its buttons, by their names
  undo: (explorer) => explorer.step(-1),
  redo: (explorer) => explorer.step(1),
  reset: (explorer) => explorer.set(explorer.beginning),
  compare: (explorer) => explorer.compare(),
  swap: (explorer) => explorer.swap(),
  copy: (explorer) => explorer.copyPython(),
  link: (explorer) => explorer.copy(explorer.link(), "link copied"),
  theme: (explorer) => explorer.setTheme(explorer.dark ? "light" : "dark"),
  full: ({ root }) => (document.fullscreenElement ? document.exitFullscreen() : root.requestFullscreen?.()),
  figure: (explorer) => explorer.save(explorer.file("svg"), "image/svg+xml", explorer.figure()),
  data: (explorer) => explorer.save(explorer.file("csv"), "text/csv", csvText(explorer.result)),
  state: (explorer) =>
    explorer.save(explorer.file("json"), "application/json", stateText(explorer.state, explorer.scene)),
  record: (explorer) => explorer.lesson.record(),
  load: ({ files }) => files.querySelector("input").click(),
  play: (explorer) => explorer.toggle(),
  sound: (explorer) => explorer.playSound(),
  stop: (explorer) => explorer.engine.stop(explorer),
};

class Explorer {
  constructor(root, scene, engine, options = {}) { // options: {address: whether the page's address holds the state}
    Object.assign(this, { root, engine, options, turn: 0, playing: null, last: null, share: 0, settled: null,
      request: null, kept: null, held: null });
    root.classList.add("fl-explorer");
    root.addEventListener("keydown", (event) => this.key(event));
    this.observer = new ResizeObserver(() => {
      this.looks = null; // letters grow with the window
      if (this.result) this.redraw();
    });
    this.open(scene);
  }

  open(scene, state = scene.initial) { // another scene, or this one anew
    Object.assign(this, { scene, state: { ...state }, result: null, kept: null, picture: null, challenge: null });
    this.history = new StateHistory({ ...scene.initial });
    this.history.record({ ...state });
    this.build();
    this.showState();
  }

  // --- what is on the page -----------------------------------------------------------------------------------------

  build() {
    this.panels = {};
    this.buttons = {};
    const { scene } = this, page = new DOMParser().parseFromString(MARKUP, "text/html").body;
    for (const name of PARTS) this[name] = page.querySelector(`.fl-${name}`);
    for (const button of page.querySelectorAll("button")) this.connect(button);
    this.buttons.link.hidden = this.buttons.theme.hidden = !this.options.address;
    this.buttons.stop.hidden = !this.engine.stop;
    this.title.textContent = scene.title;
    this.about.textContent = scene.about;
    const [scenes, challenges, box, lesson] = ["scene", "challenges", "challenge", "lesson"].map((name) =>
      page.querySelector(`.fl-${name}`));
    this.menu(scenes, scene.menu ?? [], ({ name }) => this.choose(name)).value = scene.name ?? "";
    this.challengeList = this.menu(challenges, scene.challenges, (one) => this.take(one ?? null));
    this.challengeBox = box;
    this.lesson = new Lesson(this, lesson);
    page.querySelector("input").onchange = () => this.loadFile(); // the first one takes a file
    this.side.append(...this.controlGroups());
    this.preparePlayer();
    this.pictures.replaceChildren(...scene.panels.map((name) => this.panel(name)));
    this.buttons.play.hidden = this.buttons.sound.hidden = !this.panels[this.played]; // their keys do nothing then
    // a run that is watched has no controls
    this.root.replaceChildren(...(scene.controls.length ? page.childNodes : [this.pictures]));
    this.observer.disconnect();
    this.observer.observe(this.pictures);
    if (!this.options.address) this.followTheme();
    else this.setTheme((this.dark ?? matchMedia("(prefers-color-scheme: dark)").matches) ? "dark" : "light");
  }

  connect(button) {
    this.buttons[button.name] = button;
    button.classList.add(`fl-${button.name}`);
    button.onclick = () => {
      if (button.closest(".fl-files")) this.closeFiles();
      ACTIONS[button.name](this);
    };
  }

  menu(label, entries, does) { // hidden where there is nothing to choose
    const list = label.querySelector("select");
    label.hidden = !entries.length;
    list.append(...entries.map(({ name, label: text }) => new Option(text ?? name, name)));
    list.onchange = () => does(entries.find(({ name }) => name === list.value));
    return list;
  }

  get played() { return this.scene.mechanism ? "mechanism" : "response"; } // the panel with the player

  get beginning() { return this.challenge ? challengeState(this.scene, this.challenge) : this.scene.initial; }

  follow({ challenge, state, steps, step }) { // a link
    this.take(challenge, state);
    if (steps.length) this.lesson.play(steps, step);
  }

  take(challenge, state = challenge ? challengeState(this.scene, challenge) : this.state) { // up a challenge, or none
    this.challenge = challenge;
    this.set(state);
  }

  tellChallenge() {
    const { challenge } = this;
    if (!challenge) return this.challengeBox.replaceChildren();
    const { solved, text } = challengeAnswer(challenge, this.scene, this.state, this.result);
    const answer = html("strong", { className: solved ? "fl-solved" : "", role: "status", textContent: text });
    this.challengeBox.replaceChildren(html("p", { textContent: challenge.question }), html("p", {}, [answer]));
  }

  choose(name) { // a scene of the menu: a state of this model, or one that the engine opens
    const { state } = this.scene.menu.find((one) => one.name === name);
    state ? this.set({ ...this.scene.initial, ...state }) : this.engine.choose(name);
  }

  async loadFile() {
    const field = this.files.querySelector("input");
    try { this.load(await field.files[0].text()); } catch (error) { this.fail(error.message); }
    field.value = "";
  }

  closeFiles() { // the keyboard stays at the menu
    this.files.open = false;
    this.files.querySelector("summary").focus();
  }

  controlGroups() {
    this.controls = this.scene.controls.map((about) =>
      CONTROLS[about.kind](about, (...moved) => this.change(...moved)));
    const groups = [...new Set(this.controls.map(({ about }) => about.group))],
      of = (group) => this.controls.filter(({ about }) => about.group === group).map(({ node }) => node);
    return groups.map((group) => {
      const title = GROUPS[group] ?? group;
      return title ? html("details", { className: `fl-group fl-group-${group}`, open: group !== "structure" },
        [html("summary", { textContent: title }), ...of(group)]) : html("div", { className: "fl-group" }, of(group));
    });
  }

  panel(name) {
    const title = PANELS[name]?.title ?? name.replaceAll("_", " ");
    const canvas = html("canvas", { className: "fl-canvas", role: "img", ariaLabel: title }),
      frame = html("canvas"), over = html("canvas", { className: "fl-over" });
    const caption = html("figcaption", { textContent: title }),
      stack = html("div", { className: "fl-stack" }, [frame, canvas, over]);
    const figure = html("figure", { className: `fl-panel fl-panel-${name}` }, [caption, stack]),
      panel = { name, figure, caption, frame, canvas, over, memory: {}, drawing: null, axes: null };
    this.panels[name] = panel;
    if (name === this.played) figure.append(...this.player);
    over.onclick = (event) => { if (panel.drawing?.pick || panel.drawing?.touch) this.pick(panel, event); };
    if (name === "mechanism" && this.scene.controls.length) this.drag = new BodyDrag(this, over);
    if (name === "friction") letDragPoints(this, panel);
    return figure;
  }

  preparePlayer() { // play, pause, instant, pace, sound
    const usual = this.scene.speed ?? roundDown125(this.scene.period / 2),
      paces = [...new Set([...PACES, usual])].sort((a, b) => b - a);
    this.player = [...this.pictures.children];
    this.scrub.oninput = () => { this.share = Number(this.scrub.value) / 1000; this.frame(); };
    this.pace.append(...paces.map((pace) => new Option(paceText(pace), String(pace), false, pace === usual)));
    if (this.playing) this.buttons.play.textContent = "pause";
  }

  showState() { // in the controls; those that the model is without are hidden
    for (const { name, about, node, show, refuse } of this.controls) {
      show(this.state[name]);
      if (this.clamped?.name === name) refuse(this.clamped.text);
      const [other, value] = about.when ?? [];
      const needs = about.parameter ? name : about.needs;
      node.hidden = other !== undefined && this.state[other] !== value || needs && !this.engine.has(needs, this.state);
    }
    const runs = /** @type {HTMLElement} */ (this.root.querySelector(".fl-group-run"));
    if (runs && this.result) runs.hidden = !this.result.samples; // where no panel shows a run
    this.challengeList.value = this.challenge?.name ?? "";
    this.buttons.undo.disabled = !this.history.place;
    this.buttons.redo.disabled = this.history.place + 1 >= this.history.states.length;
    this.buttons.reset.disabled = sameValue(this.state, this.beginning);
  }

  // --- from a control to the pictures ------------------------------------------------------------------------------

  change(name, value, dragging, slid = false) {
    const { parameters, structure } = this.result ?? {};
    const moved = name === "formula" && value ? pointsOnFormula(value, structure.points, parameters) : {};
    this.changeAll({ [name]: value, ...moved }, dragging, slid);
  }

  changeAll(values, dragging, slid) { // of some controls; what slides stops where a rule of the model does
    const [name] = Object.keys(values);
    if (name !== this.clamped?.name || values[name] !== this.state[name]) this.clamped = null;
    this.slid = slid;
    this.state = { ...this.state, ...values };
    this.moved = name;
    if (!dragging) this.showState();
    const { settles } = this.scene; // another parameter than this one is computed when its slider is let go
    if (dragging && settles && name !== settles) return;
    this.ask(dragging);
  }

  set(state) { // of all controls at once
    this.moved = "";
    this.slid = false;
    this.clamped = null;
    this.state = { ...state };
    this.showState();
    this.ask(false);
  }

  ask(dragging) { // at most one request per frame; a last one, with more time, when the slider has stopped
    clearTimeout(this.settled);
    if (dragging) this.settled = setTimeout(() => { this.showState(); this.ask(false); }, 250);
    this.dragging = dragging;
    if (!dragging && this.took > BUSY_AFTER) this.busy.hidden = false; // a page stands still while it computes
    const go = () => {
      this.request = null;
      this.compute(this.dragging);
    };
    this.request ??= requestAnimationFrame(() => (this.busy.hidden ? go() : setTimeout(go))); // once that is painted
  }

  compute(dragging) {
    this.began = performance.now();
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => { this.busy.hidden = false; }, BUSY_AFTER);
    this.engine.ask(this.state, dragging, this);
  }

  rest() { // nothing is being computed, but for what a long panel has left
    clearTimeout(this.waiting);
    const { progress } = this.result ?? {}, bar = this.busy.firstChild;
    this.busy.hidden = !progress;
    if (progress) Object.assign(bar, { value: progress[0], max: progress[1] }); else bar.removeAttribute("value");
  }

  show(result) { // what an engine has computed
    this.result = result;
    this.held = null;
    this.rest();
    this.error = "";
    if (result.complete) this.tell();
    this.redraw();
    if (result.complete) this.record(); // a run that is watched has no words and no states
    this.took = performance.now() - this.began;
  }

  record() {
    this.history.record({ ...this.state });
    this.showState();
    if (!this.options.address) return;
    const link = linkText(this.state, this.scene, this);
    try { history.replaceState(null, "", `#${link}`); } catch { location.hash = link; }
  }

  clamp(text, value) { // the control that slides stops there
    const { moved } = this;
    this.clamped = { name: moved, text: `${moved} stays at ${shortNumber(value)}: ${text}` };
    this.state = { ...this.state, [moved]: value };
    this.showState();
    this.ask(false);
  }

  fail(text, limits = {}) { // the pictures stay those of the last values that worked
    if (this.slid && this.moved in limits) return this.clamp(text, limits[this.moved]);
    clearTimeout(this.waiting);
    this.busy.hidden = true;
    this.held = null;
    this.frame();
    this.error = text;
    this.buttons.undo.disabled = false; // it leads to the last values that worked
    this.say(text, true);
    this.controls.find(({ name }) => name === this.moved)?.refuse?.(text); // where one looks
  }

  say(text, bad = false) {
    this.status.textContent = text;
    this.status.classList.toggle("fl-bad", bad);
  }

  tell() { // the words
    const { result } = this;
    this.say(result.status, !result.finished);
    this.words.textContent = verdict(result);
    this.numbers.replaceChildren(...equilibriumTexts(result).map((text) => html("span", {}, labelNodes(text))));
    this.tellChallenge();
    if (this.kept) this.comparison.replaceChildren(...this.comparisonTexts());
  }

  look() {
    if (this.looks) return this.looks;
    const style = getComputedStyle(this.root), read = (name) => style.getPropertyValue(`--fl-${name}`).trim();
    return this.looks = { dark: this.dark, ink: read("ink"), paper: read("paper"), grey: read("grey"),
      pale: read("pale"), line: read("line"), letters: 0.82 * parseFloat(style.fontSize) };
  }

  redraw() {
    const look = this.look(), { result, kept } = this,
      drawn = (one) => (this.panels.mechanism && one.samples ? pictureOf(one, look) : null);
    this.picture = drawn(result);
    if (kept) kept.picture = drawn(kept.result); // in the colours of now
    for (const name of this.scene.panels) if (name !== "mechanism") this.paint(this.panels[name], look);
    if (this.panels.mechanism && result.samples) this.panels.mechanism.figure.hidden = !this.picture;
    if (this.panels[this.played] && result.samples) this.showModes();
    this.frame();
  }

  drawingOf(name, result) { return PANELS[name] ? PANELS[name].draw(result, this.state) : result.drawings[name]; }

  paint(panel, look) {
    if (panel.name === "spectrum" && this.result.spectrum === undefined) return; // it waits until the slider stops
    panel.drawing = this.drawingOf(panel.name, this.result);
    panel.figure.hidden = !panel.drawing;
    if (!panel.drawing) return;
    const title = panel.drawing.title ?? panel.caption.textContent, told = [title, panel.drawing.note];
    if (panel.caption.textContent !== title) panel.caption.textContent = title;
    const label = told.filter(Boolean).join(": "); // setting anything anew would lay out the page again
    if (panel.canvas.ariaLabel !== label) panel.canvas.ariaLabel = label;
    panel.over.classList.toggle("fl-pickable", Boolean(panel.drawing.pick || panel.drawing.touch));
    if (panel.drawing.image) return panel.canvas.replaceWith(panel.canvas = html("img",
      { className: "fl-image", src: panel.drawing.image, alt: panel.name }));
    const [c, width, height] = fit(panel.canvas);
    if (!width) return;
    const [drawing, kept] = this.compared(panel.name), before = panel.axes;
    panel.axes = layoutOf(c, width, height, drawing, look, panel.memory, kept);
    if (panel.axes !== before) paintFrame(fit(panel.frame)[0], panel.axes);
    paintCurves(c, panel.axes, drawing, kept, !this.result.complete);
  }

  compared(name) { // what is painted, and over which drawing: of two scenes with many coordinates, the chosen one
    const { drawing } = this.panels[name], kept = this.kept?.drawings[name], { coordinate, structure } = this.result;
    if (PANELS[name]?.ofCoordinate && this.kept?.result.coordinate !== coordinate) return [drawing, null];
    if (!kept || name !== "response" || shownStates(structure).length <= MOST_COMPARED) return [drawing, kept];
    return [drawing, kept].map(({ curves, ...one }) => {
      const left = curves.filter(({ label }) => label === structure.labels[coordinate]),
        strip = curves.filter(({ axis }) => axis === "strip");
      return { ...one, curves: [...left.map((curve) => ({ ...curve, axis: "left" })), ...strip],
        ylabel: axisLabel(this.result, coordinate), right: "" };
    });
  }

  showModes() {
    const wholes = wholeModes(this.result.structure, this.result.samples.modes), { note } = this.picture ?? {};
    const look = this.look(), shown = JSON.stringify([note, look.dark, ...wholes.map(({ label }) => label)]);
    if (this.modes.dataset.shown === shown) return;
    this.modes.dataset.shown = shown;
    const key = wholes.map(({ label, colour, dash: [full, gap] }) => {
      const node = html("span", { className: "fl-mode", textContent: label });
      node.style.setProperty("--colour", legible(colour, look));
      if (full) node.style.setProperty("--gap", `${100 * gap / (full + gap)}%`);
      return node;
    });
    this.modes.replaceChildren(...key,
      ...(this.picture ? [html("span", { textContent: note }),
      html("span", { textContent: this.drag ? TOUCH_HINT : "" })] : []));
  }

  // --- the instant -------------------------------------------------------------------------------------------------

  get time() { return this.result.start + this.share * (this.result.stop - this.result.start); }

  // samples, and the place in them
  shownSample() { return this.held ? [this.held, 0] : this.engine.instant(this.time, this.result); }

  frame() {
    if (!this.result?.samples) return;
    const look = this.look(), t = this.held ? 0 : this.time, { structure, coordinate } = this.result,
      [samples, i] = this.shownSample();
    this.scrub.value = Math.round(1000 * this.share);
    this.scrub.ariaValueText = `${t.toFixed(4)} s`;
    this.now.textContent = this.held ? this.drag.text()
      : `t = ${t.toFixed(4)} s: ${structure.modes[samples.modes[i]]}`;
    if (this.picture) this.paintMechanism(look, samples, i);
    if (this.picture) this.drag?.paint(look);
    for (const panel of Object.values(this.panels)) {
      const { axes, over, figure } = panel, { instant } = PANELS[panel.name] ?? {};
      if (!instant || !axes || figure.hidden) continue;
      const marked = `${axes.X.at(t)} ${axes.top} ${axes.bottom} ${axes.width} ${look.grey}`;
      if (instant === "line" && panel.marked === marked) continue;
      const [c, width] = fit(over);
      if (!width) continue;
      panel.marked = marked;
      if (instant === "line") line(c, [[axes.X.at(t), axes.top], [axes.X.at(t), axes.bottom]], 1, look.grey);
      else this.paintDot(c, look, axes.X.at((axes.X.turns ? withinTurn : Number)(samples.column(coordinate)[i])),
        axes.Y.at(samples.column(otherState(structure, coordinate))[i]),
        legible(structure.colours[samples.modes[i]], look));
    }
  }

  paintMechanism(look, samples, i) {
    const [c, width, height] = fit(this.panels.mechanism.canvas);
    if (!width) return;
    if (!this.kept?.picture) return this.picture.draw(c, width, height, this.picture.scene,
      this.picture.row(samples, i));
    const { picture, result } = this.kept, half = width / 2,
      [before, k] = this.kept.instant(result.start + this.share * (result.stop - result.start));
    this.picture.draw(c, half, height, this.picture.scene, this.picture.row(samples, i));
    c.save();
    c.translate(half, 0);
    picture.draw(c, half, height, picture.scene, picture.row(before, k));
    c.restore();
    Object.assign(c, { fillStyle: look.ink, font: `${look.letters}px system-ui`, textBaseline: "top",
      textAlign: "left" });
    c.fillText("now", 4, 4);
    c.fillText("kept", half + 4, 4);
  }

  paintDot(c, look, x, y, colour) {
    Object.assign(c, { fillStyle: colour, strokeStyle: look.ink, lineWidth: 1.5 });
    c.beginPath();
    c.arc(x, y, 5, 0, 7);
    c.fill();
    c.stroke();
  }

  toggle() {
    if (!this.panels[this.played]) return; // nothing is played here
    if (this.playing) {
      cancelAnimationFrame(this.playing);
      this.playing = this.last = null;
    } else this.playing = requestAnimationFrame((now) => this.tick(now));
    this.buttons.play.textContent = this.playing ? "pause" : "play";
  }

  tick(now) {
    if (this.result && this.last !== null) this.share = (this.share
      + (now - this.last) / 1000 * Number(this.pace.value) / (this.result.stop - this.result.start)) % 1;
    this.last = now;
    this.frame();
    this.playing = requestAnimationFrame((later) => this.tick(later));
  }

  copyPython() {
    try { this.copy(this.engine.python(this.state), "copied as Python");
    } catch (error) { this.say(error.message, true); }
  }

  async playSound() {
    this.audio ??= new AudioContext();
    this.heard.textContent = "";
    try { this.sound(await this.engine.hear()); } catch (error) { this.heard.textContent = error.message; }
  }

  sound({ samples, rate, text }) {
    const buffer = this.audio.createBuffer(1, samples.length, rate), source = this.audio.createBufferSource();
    buffer.getChannelData(0).set(samples);
    source.buffer = buffer;
    source.connect(this.audio.destination);
    source.start();
    this.heard.textContent = text;
  }

  // --- states ------------------------------------------------------------------------------------------------------

  step(by) {
    // values that gave no picture are not in the history
    if (this.error && by < 0) return this.set(this.history.present);
    const state = this.history.step(by);
    if (state) this.set(state);
  }

  compare() { // keep the scene that is shown, or drop the one that is kept
    if (this.kept) this.kept = null; else this.keep();
    this.buttons.compare.setAttribute("aria-pressed", String(Boolean(this.kept)));
    this.buttons.swap.disabled = !this.kept;
    this.comparison.replaceChildren(...(this.kept ? this.comparisonTexts() : []));
    this.redraw();
  }

  keep() {
    const { result } = this, drawings = Object.fromEntries(this.scene.panels.map((name) =>
      [name, this.panels[name].drawing])), { samples } = result;
    this.kept = { result, drawings, picture: this.picture, state: { ...this.state }, verdict: verdict(result),
      instant: (t) => [samples, nearestTime(samples.times, t)] };
  }

  swap() {
    const { state } = this.kept;
    this.keep();
    this.set(state);
  }

  comparisonTexts() { // in what the two scenes differ, and what the kept one does
    const before = this.kept.state, names = differences(before, this.state),
      values = (state) => names.map((name) => `${name} = ${shownValue(state[name])}`).join(", ");
    if (!names.length) return [html("p",
      { textContent: "The scene is kept, dotted: move a control, and both are seen." })];
    return [`dotted, kept: ${values(before)}`, `solid, now: ${values(this.state)}`,
      `Kept: ${this.kept.verdict}`].map((text) => html("p", { textContent: text }));
  }

  link() { return `${location.href.split("#")[0]}#${linkText(this.state, this.scene, this)}`; }

  load(text) {
    const { model, scene, changed, steps } = stateFromText(text);
    if (model !== this.scene.model) {
      const other = changed && this.scene.menu?.some(({ name, state }) => name === scene && !state);
      if (other) return this.engine.choose(scene, changed);
      throw new RangeError(`the state must be that of ${this.scene.model}, got that of ${model}: open it there`);
    }
    if (steps) this.lesson.play(lessonSteps(steps, this.scene));
    else this.set({ ...this.scene.initial, ...changed });
  }

  startAt(touched, coordinate) { // a run from these values of states; all others as in steady sliding
    const own = startState(this.result, touched, this.shownSample()).map((value) => roundNumber(value, 5)).join(", ");
    this.set({ ...this.state, start: "own", own, coordinate, window: "how it begins" });
    this.share = 0;
    if (!this.playing && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.toggle();
  }

  pick(panel, event) { // a click into a diagram
    const box = panel.over.getBoundingClientRect(), { X, Y } = panel.axes, x = X.value(event.clientX - box.left),
      y = Y.value(event.clientY - box.top);
    if (x < X.low || x > X.high || y < Y.low || y > Y.high) return;
    if (panel.drawing.touch) return this.startAt(panel.drawing.touch(x, y), this.result.coordinate);
    const picked = Object.fromEntries(panel.drawing.pick.map((name, i) => [name, [x, y][i]]).filter(([name]) => name));
    for (const [name, value] of Object.entries(picked)) {
      const { about } = this.controls.find((control) => control.name === name),
        step = sliderStep(about.low, about.high);
      picked[name] = Math.min(Math.max(roundNumber(step * Math.round(value / step)), about.low), about.high);
    }
    this.set({ ...this.state, ...picked });
  }

  figure() { // all plots as one picture to print, on white paper
    const shown = this.scene.panels.map((name) => this.panels[name]).filter(({ figure, drawing }) =>
      !figure.hidden && drawing?.curves);
    const [width, height] = [420, 300], columns = Math.min(2, shown.length), rows = Math.ceil(shown.length / columns);
    const look = { dark: false, ink: "#000000", paper: "#ffffff", grey: "#767676", line: "#dddddd", letters: 12 },
      c = new SvgContext(columns * width, rows * height, look.paper);
    shown.forEach(({ name, memory }, i) => {
      c.save();
      c.translate(width * (i % columns), height * Math.floor(i / columns));
      const [drawing, kept] = this.compared(name);
      const layout = layoutOf(c, width, height, drawing, look, { ...memory }, kept);
      paintFrame(c, layout);
      paintCurves(c, layout, drawing, kept);
      c.restore();
    });
    return c.text();
  }

  file(ending) { return `${this.scene.model.replace(/\(.*/s, "")}.${ending}`; }

  save(name, type, content) {
    const link = html("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async copy(text, said) {
    try { await navigator.clipboard.writeText(text); } catch { // a page opened from a file may not use the clipboard
      const area = html("textarea", { value: text });
      this.root.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    this.copied = text;
    this.say(said);
  }

  // --- keys and looks ----------------------------------------------------------------------------------------------

  key(event) {
    event.stopPropagation(); // a notebook takes keys for its own commands
    if (event.key === "Escape" && this.files.open) this.closeFiles();
    const { tagName, type } = event.target;
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(tagName) && type !== "range" && type !== "checkbox" || event.ctrlKey
      || event.metaKey || event.altKey) return;
    const button = Object.values(this.buttons).find(({ dataset }) => dataset.key === event.key);
    if (button && !button.hidden && !(event.key === " " && tagName !== "BODY"
      && tagName !== "DIV")) { event.preventDefault(); button.click(); }
  }

  setTheme(name) {
    this.dark = name === "dark";
    this.root.dataset.theme = name;
    this.looks = null;
    this.buttons.theme.textContent = this.dark ? "light" : "dark";
    if (this.result) this.redraw();
  }

  followTheme() { // of the page around
    const shade = (element) => { const [r, g, b,
      a = 1] = getComputedStyle(element).backgroundColor.match(/[\d.]+/g).map(Number);
      return a ? (r + g + b) / 765 : null; };
    let around = this.root, light = null;
    for (; around && light === null; around = around.parentElement) if (around !== this.root) light = shade(around);
    const dark = light === null ? matchMedia("(prefers-color-scheme: dark)").matches : light < 0.5;
    if (dark !== this.dark) this.setTheme(dark ? "dark" : "light");
  }

  close() {
    this.observer.disconnect();
    cancelAnimationFrame(this.playing);
    clearTimeout(this.settled);
    clearTimeout(this.waiting);
    this.audio?.close();
  }
}

function nearestTime(times, t) { // the place of the last time that is not after t
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}
