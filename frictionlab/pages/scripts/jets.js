// Machine code of the jets of a structure's modes: the operations of a tape in sequence, within a loop over the orders, as
// hybrid/codegen/jet_codegen.py writes them.  They are those of the interpreter (hybrid/kernels/jets.py) in its sequence, so
// that a run may change over at any step and no bit depends on it.  Kernels call a mode's code by its place in their table.
const [AFFINE, PRODUCT, SQUARE, QUOTIENT, RATE, POWER] = [0, 1, 2, 3, 4, 5];
const { i32, i64, f64, v128 } = KIND;
const [VALUE, SUM] = [0, 1]; // functions: that of the kernels, which is imported, and what is written here
const JET_TYPES = [[[i64, f64], [f64]], [[i32, i32, i32], [f64]], [[i32, i32, i32, i32, i64], []]];
const MODE_TYPE = 2;

function writeSum() { // of a[j] b[-j] over j < n, in four parts that do not wait for each other
  const code = new Assembler(), [a, b, n, first, second, one, two, three] = [0, 1, 2, 3, 4, 5, 6, 7];
  const pairs = (sum, ahead, behind) => code.get(a).loadVector(ahead).get(b).loadVector(behind).get(b).loadVector(behind).exchange().multiplyVectors().get(sum).addVectors().set(sum);
  const further = (part, j) => code.get(n).whole(j + 1).atLeast().if().get(part).get(a).load(NUMBER * j).get(b).load(NUMBER * (3 - j)).multiply().add().set(part).end();
  code.move(b, -3 * NUMBER).block().loop().get(n).whole(4).atLeast().isZero().branchIf(1);
  pairs(first, 0, 2 * NUMBER);
  pairs(second, 2 * NUMBER, 0);
  code.move(a, 4 * NUMBER).move(b, -4 * NUMBER).move(n, -4).branch(0).end().end();
  code.get(first).lane(0).set(one).get(first).lane(1).set(two).get(second).lane(0).set(three);
  [one, two, three].forEach(further);
  code.get(one).get(two).add().get(three).get(second).lane(1).add().add();
  return { type: 1, locals: [[2, v128], [3, f64]], code };
}

class ModeWriter { // function (z, constants, terms, J, order)
  constructor(tape) { // {inputs, row, first, ops: [kind, a, b], terms: slots, flow}
    Object.assign(this, tape, { code: new Assembler() });
    [this.z, this.constants, this.terms, this.J, this.order, this.last, this.k, this.column, this.kNumber, this.share, this.total, this.values] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
  }

  write() {
    const { code, inputs, z, J, k, kNumber, column, last, order, share, flow, row } = this;
    for (let i = 0; i < inputs; i++) this.put(J, i, () => code.get(z).load(NUMBER * i));
    this.ops.forEach((op, i) => this.put(J, inputs + i, () => this.value(i, ...op)));
    code.get(order).wrap().keep(last).isZero().if().return().end();
    code.whole(1).set(k).number(1).set(kNumber).get(J).whole(NUMBER).plus().set(column).loop();
    code.number(1).get(kNumber).divide().set(share);
    for (let i = 0; i < inputs; i++) this.put(column, i, () => this.behind(flow[i]).load(0).get(share).multiply());
    this.ops.forEach((op, i) => this.put(column, inputs + i, () => this.coefficient(i, ...op)));
    code.get(k).get(last).equal().if().return().end();
    code.move(k, 1).move(column, NUMBER).get(kNumber).number(1).add().set(kNumber).branch(0).end();
    return { type: MODE_TYPE, locals: [[3, i32], [3 + inputs + this.ops.length, f64]], code };
  }

  put(at, slot, write) { // a value into its local and its row
    this.code.get(at);
    write();
    this.code.keep(this.values + slot).store(this.row * slot);
  }

  of(slot) { return this.code.get(this.values + slot); } // at the order at hand
  start(slot) { return this.code.get(this.J).load(this.row * slot); }
  behind(slot) { return this.code.get(this.column).whole(this.row * slot - NUMBER).plus(); } // address of the order before

  sum(a, b, count) { // over 1 <= j < 1 + count of the coefficients j of a and k - j of b
    this.code.get(this.J).whole(this.row * a + NUMBER).plus();
    this.behind(b);
    count();
    return this.code.call(SUM);
  }

  affine(a, b, constant) {
    const { code } = this;
    if (constant !== null) code.get(this.constants).load(NUMBER * constant); else code.number(0);
    for (let j = a; j < b; j++) { code.get(this.terms).load(NUMBER * j); this.of(this.slots[j]).multiply().add(); }
  }

  value(i, kind, a, b) { // coefficient 0
    if (kind === AFFINE) return this.affine(a, b, this.first + i);
    if (kind === RATE) return this.code.number(0);
    if (kind > POWER) { this.code.long(kind); return this.of(a).call(VALUE); }
    this.of(a);
    return this.of(kind === SQUARE ? a : b)[kind === QUOTIENT ? "divide" : "multiply"]();
  }

  coefficient(i, kind, a, b) { // coefficient k > 0
    const { code, k, kNumber } = this, out = this.inputs + i, all = () => code.get(k);
    if (kind === AFFINE) return this.affine(a, b, null);
    if (kind === RATE) { code.get(kNumber); return this.of(a).multiply(); }
    if (kind > POWER) return this.sum(out - 1, b, all).get(kNumber).divide();
    if (kind === QUOTIENT) { this.of(a); this.sum(b, out, all).subtract(); return this.start(b).divide(); }
    if (kind === SQUARE) return this.square(a);
    this.sum(a, b, () => code.get(k).whole(-1).plus());
    this.start(a);
    this.of(b).multiply().add();
    this.of(a);
    return this.start(b).multiply().add();
  }

  square(a) { // each pair once
    const { code, k, J, total, row } = this;
    code.number(2);
    this.sum(a, a, () => code.get(k).whole(-1).plus().whole(1).shiftRight()).multiply().set(total);
    code.get(k).whole(1).and().isZero().if().get(total);
    for (let i = 0; i < 2; i++) code.get(J).get(k).whole(NUMBER / 2).times().plus().load(row * a); // J[a, k/2]
    code.multiply().add().set(total).end().get(total).number(2);
    this.start(a).multiply();
    return this.of(a).multiply().add();
  }
}

function tapesOf(structure) { // one for each mode
  const array = (name) => structure.arrays.find((each) => each.name === name);
  const read = (name) => { const { type, data } = array(`code.${name}`); return data ? Array.from(new KINDS[type](bytesOf(data).buffer), Number) : []; };
  const [ops, slots, ranges, flow] = ["ops", "term_slots", "mode_ops", "flow"].map(read);
  const inputs = structure.states.length, row = NUMBER * array("scratch.jets").shape[1];
  return structure.modes.map((_, mode) => {
    const [first, end] = [ranges[mode], ranges[mode + 1]];
    const operations = Array.from({ length: end - first }, (_, i) => ops.slice(3 * (first + i), 3 * (first + i + 1)));
    return { inputs, row, first, slots, flow: flow.slice(mode * inputs, (mode + 1) * inputs), ops: operations };
  });
}

async function compileJets({ exports }, structure) { // the place of each mode's code in the kernels' table, 0 where there is none
  const tapes = tapesOf(structure), interpreted = (tape) => tape.ops.some(([kind]) => kind === POWER); // whose series end near zero
  const written = [...tapes.keys()].filter((mode) => !interpreted(tapes[mode])), names = written.map((mode) => `mode${mode}`);
  const functions = [writeSum(), ...written.map((mode) => new ModeWriter(tapes[mode]).write())];
  const code = wasmModule({ types: JET_TYPES, imports: [{ name: "memory" }, { name: "value", type: 0 }], functions, exported: names });
  const { instance } = await WebAssembly.instantiate(code, { kernels: { memory: exports.memory, value: exports.frictionlab_function_value } });
  const table = exports.__indirect_function_table, places = new BigInt64Array(tapes.length), first = table.grow(written.length);
  written.forEach((mode, i) => { table.set(first + i, instance.exports[names[i]]); places[mode] = BigInt(first + i); });
  return places;
}
