// The front end as a widget: its engine is the Python process. The state goes there, and the result comes back, now
// or later.
const floats = (view) => new Float64Array(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
const decoded = (data) => { // arrays of bytes as numbers, wherever they are
  if (ArrayBuffer.isView(data)) return floats(data);
  if (Array.isArray(data)) return data.map(decoded);
  if (data === null || typeof data !== "object") return data;
  return Object.fromEntries(Object.entries(data).map(([name, part]) => [name, decoded(part)]));
};

const LONGEST_WAIT = 60000; // ms for an answer of Python

class PythonEngine {
  /** @type {Promise<any> | null} */
  waiting = null; // for an answer
  answered = (..._message) => {};
  parameters = null;
  text = ""; // Python that makes the model and its run
  images = {};

  constructor(model) { this.model = model; }

  ask(state, dragging, explorer) {
    const waits = this.model.get("sliding") && !dragging && !explorer.error; // for what sliding has left out
    if (!waits && sameValue(state, this.model.get("state"))) return explorer.rest(); // Python would answer nothing
    this.model.set("state", state);
    this.model.set("sliding", Boolean(dragging));
    this.model.save_changes();
  }

  has(name) { return !this.parameters || name in this.parameters; }
  choose(name, changed = {}) { this.model.send({ open: { name, changed } }); }

  async stop(explorer) { // what is done in parts stops by a message, a computation that hears none by ctrl-C
    this.model.send({ stop: true });
    if (!this.model.get("computing")) return; // the kernel may run a cell
    try { await this.model.widget_manager.kernel.interrupt(); // not every front end has them
    } catch { explorer.say("This server does not let a computation be stopped: wait until it is done.", true); }
  }

  python() { return this.text; }

  result() { // the picture, with its arrays as numbers
    const { structure, drawings, ...picture } = this.model.get("picture"), { highest } = this.model.get("scene");
    const result = { ...decoded(picture), structure, highest };
    this.parameters = picture.parameters;
    this.text = picture.python ?? this.text;
    if (result.samples) {
      const { times, modes, columns } = result.samples;
      result.samples = samplesByName(times, modes, Object.keys(columns), Object.values(columns));
    }
    result.drawings = Object.fromEntries(Object.entries(drawings).map(([name, drawing]) =>
      [name, drawing.image ? { image: this.imageOf(name, drawing.image) } : decoded(drawing)]));
    return result;
  }

  imageOf(name, bytes) { // the address of a picture that matplotlib has drawn
    URL.revokeObjectURL(this.images[name]);
    return (this.images[name] = URL.createObjectURL(new Blob([bytes], { type: "image/svg+xml" })));
  }

  instant(t, { samples }) { return [samples, nearestTime(samples.times, t)]; }

  async hear() {
    this.waiting ??= this.answerOfPython().finally(() => { this.waiting = null; });
    const [{ text, rate }, [bytes]] = await this.waiting;
    if (!bytes) throw new RangeError(text);
    const samples = new Int16Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    return { samples: Float32Array.from(samples, (v) => v / 32767), rate, text };
  }

  answerOfPython() { // [content, buffers]
    return new Promise((answered, failed) => {
      const late = () => failed(new RangeError("Python does not answer: see whether its kernel runs."));
      const timer = setTimeout(late, LONGEST_WAIT);
      this.answered = (...message) => { clearTimeout(timer); answered(message); };
      this.model.send({ hear: true });
    });
  }
}

function render({ model, el }) {
  const root = html("div"), engine = new PythonEngine(model),
    explorer = new Explorer(root, model.get("scene"), engine, { address: model.get("scene").address });
  let link = model.get("scene").address ? location.hash : "", due = false;
  el.append(root);
  function show() { // several values change in one message: they are shown once
    due = false;
    const { picture, error } = { picture: model.get("picture"), error: model.get("error") };
    if (error) return explorer.fail(error, model.get("limits"));
    if (picture.parameters) explorer.show(engine.result());
  }
  const soon = () => { if (!due) queueMicrotask(show); due = true; };
  const reopen = () => {
    explorer.open(model.get("scene"), model.get("state"));
    if (link) follow(readLink(link, model.get("scene")));
  };
  const take = () => { // controls that were set in Python
    if (!sameValue(explorer.state, model.get("state"))
      && Object.keys(explorer.state).every((name) => name in model.get("state"))) {
      explorer.state = { ...model.get("state") };
      explorer.showState();
    }
  };
  function follow(asked) {
    link = "";
    explorer.follow(asked);
  }
  const changes = { "change:scene": reopen, "change:state": take, "change:picture": soon, "change:error": soon,
    "msg:custom": (content, buffers) => engine.answered(content, buffers) };
  for (const [name, does] of Object.entries(changes)) model.on(name, does);
  model.set("shown", true);
  model.save_changes();
  take();
  show();
  if (link) {
    const asked = readLink(link, model.get("scene"));
    asked.scene && asked.scene !== model.get("scene").name ? engine.choose(asked.scene) : follow(asked);
  }
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (!calm && model.get("scene").plays) explorer.toggle();
  const themes = new MutationObserver(() => { if (!explorer.options.address) explorer.followTheme(); });
  themes.observe(document.body, { attributes: true });
  requestAnimationFrame(() => { if (!explorer.options.address) explorer.followTheme(); }); // once it is in the page
  return () => {
    for (const [name, does] of Object.entries(changes)) model.off(name, does);
    themes.disconnect();
    explorer.close();
  };
}

export default { render };
