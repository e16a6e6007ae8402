// The solver: calls of the kernels, compiled to WebAssembly, and the loop that goes on whenever a record is full, as
// in methods/taylor.py. Every kernel takes the address of a table of 64-bit words: places for its results, then its
// arguments; those of an array are its address and its lengths.
const [RUNNING, FINISHED, NO_ADMISSIBLE_MODE] = [0, 1, 2];
const [MODE, STEPS, EVENTS, POINTS] = [0, 1, 2, 3];
const RECORDS = 24; // there is room for so many records at first, each of 2048 steps and as many events
const MOST_RECORDS = 768; // for one and a half million steps, some 160 MB
const HASTE = 100, FEW_STEPS = 128; // with a patience of fewer milliseconds the clock is read after so many steps
const SAMPLES = 4096; // most samples in a call
const KINDS = { i8: BigInt64Array, f8: Float64Array, u4: Uint32Array, u1: Uint8Array, b1: Uint8Array };
const NO_MODE = -1n;

const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

async function loadSolver() {
  const packed = new Blob([bytesOf(SOLVER.module)]).stream().pipeThrough(new DecompressionStream("gzip"));
  const code = await new Response(packed).arrayBuffer();
  const { instance } = await WebAssembly.instantiate(code, {});
  return new Solver(instance.exports);
}

class Solver {
  constructor(exports) {
    this.exports = exports;
    this.start = (exports.__heap_base.value + 63) & ~63;
    this.structure = null;
    this.reset();
  }

  reset() { // forget all arrays
    this.heap = this.start;
    this.arrays = {};
    this.fixed = {};
    this.room = { step: RECORDS, event: RECORDS, point: RECORDS };
    this.tables = {};
    for (const [name, { results, arguments: given }] of Object.entries(SOLVER.tables)) {
      const words = results.length + given.reduce((sum, [, , axes]) => sum + 1 + axes, 0);
      this.tables[name] = { place: this.allocate(8 * words), words };
    }
    this.views();
  }

  allocate(bytes) {
    const place = this.heap;
    this.heap = (place + bytes + 63) & ~63;
    const missing = this.heap + 65536 - this.exports.memory.buffer.byteLength;
    if (missing > 0) this.exports.memory.grow(Math.ceil(missing / 65536));
    return place;
  }

  array(name, type, shape, room = 1) {
    const length = shape.reduce((a, b) => a * b, 1);
    this.arrays[name] = { type, shape, length: length * room,
      place: this.allocate(room * length * KINDS[type].BYTES_PER_ELEMENT) };
  }

  makeRoom(kind) { // for twice as many records of steps or events; false if these would be too many
    if (2 * this.room[kind] > MOST_RECORDS) return false;
    const moved = Object.entries(this.arrays).filter(([name]) => name.startsWith(`record.${kind}`)).map(([, a]) => {
      const before = { place: a.place, bytes: a.length * KINDS[a.type].BYTES_PER_ELEMENT };
      a.length *= 2;
      return [before, a.place = this.allocate(2 * before.bytes)];
    });
    this.room[kind] *= 2;
    this.views();
    const all = new Uint8Array(this.exports.memory.buffer);
    for (const [{ place, bytes }, to] of moved) all.copyWithin(to, place, place + bytes);
    return true;
  }

  views() { // make new views of the memory: those from before it grew are void
    const buffer = this.exports.memory.buffer;
    for (const a of Object.values(this.arrays)) a.view = new KINDS[a.type](buffer, a.place, a.length);
    for (const t of Object.values(this.tables)) {
      t.integers = new BigInt64Array(buffer, t.place, t.words);
      t.floats = new Float64Array(buffer, t.place, t.words);
    }
  }

  call(name, given = {}) { // `given`: arguments by name that take precedence over the solver's arrays and numbers
    const { results, arguments: leaves } = SOLVER.tables[name], table = this.tables[name];
    let at = results.length;
    for (const [leaf, type, axes] of leaves) {
      const plain = leaf.replace(/^system\./, "");
      const value = given[plain] ?? this.arrays[plain] ?? this.fixed[plain];
      if (axes) {
        table.integers[at++] = BigInt(value.place);
        for (const length of value.shape) table.integers[at++] = BigInt(length);
      } else if (type === "f8") table.floats[at++] = value;
      else table.integers[at++] = BigInt(value);
    }
    if (this.exports[name](table.place) !== 0) throw new Error(`the kernel ${name} failed`);
    return table;
  }

  load(structure) { // make the arrays of a structure
    if (this.structure === structure) return;
    this.reset();
    const { tol } = SCENE.method, { order } = structure, n = structure.states.length;
    const numbers = { constants: structure.constants, terms: structure.terms };
    for (const a of structure.arrays) {
      if (!a.shape) this.fixed[a.name] = a.value;
      else this.array(a.name, a.type, a.shape, a.name.startsWith("record.") ? RECORDS : 1);
    }
    for (const set of ["numbers", "magnitudes"]) for (const [part,
      length] of Object.entries(numbers)) this.array(`${set}.${part}`, "f8", [length]);
    this.array("which", "i8", [SAMPLES]);
    this.array("times", "f8", [SAMPLES]);
    this.array("out", "f8", [SAMPLES, n]);
    this.views();
    // the arrays of another structure were there
    new Uint8Array(this.exports.memory.buffer, this.start, this.heap - this.start).fill(0);
    Object.assign(this.fixed, { order, "truncation.order": order, "truncation.tol": tol });
    for (const a of structure.arrays) if (a.data) this.write(a);
    this.structure = structure;
    this.useJets(structure);
  }

  async useJets(structure) { // machine code of its modes, as soon as it is compiled; until then they are interpreted
    if (this.arrays.shared_terms.length > 0) return; // so are products of matrices always
    structure.jets ??= await compileJets(this, structure);
    if (this.structure === structure) this.arrays["code.native"].view.set(structure.jets);
  }

  write(a) {
    const bytes = bytesOf(a.data);
    new Uint8Array(this.exports.memory.buffer, this.arrays[a.name].place, bytes.length).set(bytes);
  }

  begin(values, state, end) { // set numbers, state and clock of a new run; whether its first mode was found
    const { structure, arrays } = this, chatter = values[structure.parameters.indexOf("chatter")] ?? 0;
    const all = structure.numbers(values), constants = all.slice(0, structure.constants),
      terms = [...all.slice(structure.constants), ...arrays.shared_terms.view]; // of the tape, then of matrices
    if (!all.every(Number.isFinite)) {
      const zeros = structure.parameters.filter((_, i) => values[i] === 0).map((name) => `${name} = 0`);
      throw new RangeError(`the equations must have finite values, and have none with ${zeros.join(", ")
        || "these parameters"}: move back what was changed`);
    }
    for (const [part, list] of [["constants", constants], ["terms", terms]]) {
      arrays[`numbers.${part}`].view.set(list);
      arrays[`magnitudes.${part}`].view.set(list.map(Math.abs));
    }
    for (const a of structure.arrays) {
      if (a.shape && (a.name === "change.length" || a.name.startsWith("run.")
        || a.name.startsWith("scratch."))) { arrays[a.name].view.fill(KINDS[a.type] === BigInt64Array ? 0n : 0);
        if (a.data) this.write(a); }
    }
    arrays["run.state"].view.set(state);
    arrays["run.sizes"].view.set(state.map(Math.abs));
    arrays["run.times"].view.set([0, end, 0, chatter, 0]);
    arrays["scratch.ended"].view[0] = NO_MODE;
    const start = arrays["run.state"], rounding = { "rounding.sizes": start, "rounding.share": SCENE.method.rounding };
    const found = this.call("select_mode", { z: start, ...rounding });
    arrays["run.counts"].view[MODE] = found.integers[0];
    return found.integers[0] >= 0n;
  }

  advance(record) {
    return Number(this.call(this.structure.affine ? "advance_affine" : "advance_taylor", record).integers[0]);
  }

  record(steps, events, length) { // the parts of the arrays behind what has been recorded, with room for `length` more
    const found = {};
    for (const a of this.structure.arrays.filter(({ name }) => name.startsWith("record."))) {
      const [rows, ...shape] = a.shape, row = shape.reduce((x, y) => x * y, KINDS[a.type].BYTES_PER_ELEMENT);
      const before = a.name.startsWith("record.step") ? steps : a.name.startsWith("record.event") ? events : 0;
      found[a.name] = { shape: [Math.min(rows, length), ...shape], place: this.arrays[a.name].place + row * before };
    }
    return found;
  }

  run(structure, values, state, end, patience = Infinity) { // to the end time, or for about `patience` milliseconds
    this.load(structure);
    const { arrays } = this, began = performance.now(), capacity = arrays["record.step_modes"].shape[0];
    const length = patience < HASTE ? Math.min(capacity, FEW_STEPS) : capacity; // between two looks at the clock
    let [status, steps, events] = [this.begin(values, state, end) ? RUNNING : NO_ADMISSIBLE_MODE, 0, 0];
    const full = (kind, count) => count + length > this.room[kind] * capacity && !this.makeRoom(kind);
    while (status === RUNNING && !full("step", steps) && !full("event", events)) {
      const counts = arrays["run.counts"].view; // taken again each time, as the memory may have grown
      for (const part of [STEPS, EVENTS, POINTS]) counts[part] = 0n;
      status = this.advance(this.record(steps, events, length));
      steps += Number(counts[STEPS]);
      events += Number(counts[EVENTS]);
      if (performance.now() - began > patience) break;
    }
    const part = (name, count, width) => arrays[`record.${name}`].view.subarray(0, count * width),
      n = structure.states.length;
    return {
      structure, values, status, steps, events, end: arrays["run.times"].view[0],
        state: Array.from(arrays["run.state"].view),
      mode: Number(arrays["run.counts"].view[MODE]), milliseconds: performance.now() - began,
      stepTimes: part("step_times", steps, 2), stepModes: part("step_modes", steps, 1),
      eventTimes: part("event_times", events, 1), eventCodes: part("event_codes", events, 3),
        eventStates: part("event_states", events, 2 * n),
    };
  }
}
