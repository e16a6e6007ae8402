// Machine code of the jets of a structure's modes: the operations of a tape in sequence, within a loop over the
// orders, as hybrid/codegen/jet_codegen.py writes them. It does the operations of the interpreter
// (hybrid/kernels/jets.py) in the same sequence: a run may change from one to the other at any step, and its numbers
// stay the same to the last bit. Kernels call a mode's code by its index in their table.
const [AFFINE, PRODUCT, SQUARE, QUOTIENT, RATE, POWER] = [0, 1, 2, 3, 4, 5];
const { i32, i64, f64, v128 } = KIND;
// indices of functions: two kernels, which are imported, then two that are written here
const [VALUE, POWER_VALUE, SUM, LEAST_RATIO] = [0, 1, 2, 3];
const JET_TYPES = [[[i64, f64], [f64]], [[i32, i32, i32], [f64]], [[i32, i32, i32, i32, i64], []],
  [[f64, f64], [f64]], [[f64], [f64]]];
const MODE_TYPE = 2, POWER_TYPE = 3, RATIO_TYPE = 4;
const TO_INTEGER = 1.5 * 2 ** 52; // adding it to a number rounds this to an integer, which is then in the last bits

function writeSum() { // the sum of a[j] b[-j] over j < n, in four partial sums that do not wait for each other
  const code = new Assembler(), [a, b, n, first, second, one, two, three] = [0, 1, 2, 3, 4, 5, 6, 7];
  const pairs = (sum, ahead, behind) =>
    code.get(a).loadVector(ahead).get(b).loadVector(behind).get(b).loadVector(behind)
      .exchange().multiplyVectors().get(sum).addVectors().set(sum);
  const further = (part, j) => code.get(n).whole(j
    + 1).atLeast().if().get(part).get(a).load(NUMBER * j).get(b).load(NUMBER * (3
    - j)).multiply().add().set(part).end();
  code.move(b, -3 * NUMBER).block().loop().get(n).whole(4).atLeast().isZero().branchIf(1);
  pairs(first, 0, 2 * NUMBER);
  pairs(second, 2 * NUMBER, 0);
  code.move(a, 4 * NUMBER).move(b, -4 * NUMBER).move(n, -4).branch(0).end().end();
  code.get(first).lane(0).set(one).get(first).lane(1).set(two).get(second).lane(0).set(three);
  [one, two, three].forEach(further);
  code.get(one).get(two).add().get(three).get(second).lane(1).add().add();
  return { type: 1, locals: [[2, v128], [3, f64]], code };
}

// 2^(least_ratio/order): a power has a series of this order if its base is more than so many times its rate
function writeLeastRatio() {
  const code = new Assembler(), { least_ratio, exp2 } = SCENE.method, [x, shifted, part, sum] = [0, 1, 2, 3];
  code.number(least_ratio).get(x).divide().keep(x).number(0.5).subtract().number(TO_INTEGER).add().keep(shifted);
  code.number(TO_INTEGER).subtract().set(part).get(x).get(part).subtract().set(part);
  code.number(exp2.at(-1)).set(sum);
  exp2.slice(0, -1).reverse().forEach((c) => code.get(sum).get(part).multiply().number(c).add().set(sum));
  code.get(part).number(1).add().get(part).number(1).get(part).subtract().multiply().get(sum).multiply().add().bits();
  code.get(shifted).bits().long(52).shiftLongLeft().addLong().fromBits();
  return { type: RATIO_TYPE, locals: [[3, f64]], code };
}

class ModeWriter { // function (z, constants, terms, J, order)
  constructor(tape) { // {inputs, row, first, ops: [kind, a, b], terms: slots, flow}
    Object.assign(this, tape, { code: new Assembler() });
    [this.z, this.constants, this.terms, this.J, this.order, this.last, this.k, this.column, this.kNumber, this.share,
      this.total, this.leastRatio, this.values] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
  }

  write() {
    const { code, inputs, z, J, k, kNumber, column, last, order, share, flow } = this;
    for (let i = 0; i < inputs; i++) this.put(J, i, () => code.get(z).load(NUMBER * i));
    this.ops.forEach((op, i) => this.put(J, inputs + i, () => this.value(i, ...op)));
    code.get(order).wrap().keep(last).isZero().if().return().end();
    if (this.ops.some(([kind]) => kind === POWER)) code.get(last).asNumber().call(LEAST_RATIO).set(this.leastRatio);
    code.whole(1).set(k).number(1).set(kNumber).get(J).whole(NUMBER).plus().set(column).loop();
    code.number(1).get(kNumber).divide().set(share);
    for (let i = 0; i < inputs; i++) this.put(column, i, () => this.behind(flow[i]).load(0).get(share).multiply());
    this.ops.forEach((op, i) => this.put(column, inputs + i, () => this.coefficient(i, ...op)));
    code.get(k).get(last).equal().if().return().end();
    code.move(k, 1).move(column, NUMBER).get(kNumber).number(1).add().set(kNumber).branch(0).end();
    return { type: MODE_TYPE, locals: [[3, i32], [4 + inputs + this.ops.length, f64]], code };
  }

  put(at, slot, write) { // store a value in its local and in its row of the jets
    this.code.get(at);
    write();
    this.code.keep(this.values + slot).store(this.row * slot);
  }

  of(slot) { return this.code.get(this.values + slot); } // the coefficient of the present order
  start(slot) { return this.code.get(this.J).load(this.row * slot); }
  // address of coefficient k - 1
  behind(slot) { return this.code.get(this.column).whole(this.row * slot - NUMBER).plus(); }

  sum(a, b, count) { // the sum of a[j] b[k - j] over 1 <= j < 1 + count
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
    if (kind === POWER) return this.powerValue(a, this.first + i);
    if (kind > POWER) { this.code.long(kind); return this.of(a).call(VALUE); }
    this.of(a);
    return this.of(kind === SQUARE ? a : b)[kind === QUOTIENT ? "divide" : "multiply"]();
  }

  coefficient(i, kind, a, b) { // coefficient k > 0
    const { code, k, kNumber } = this, out = this.inputs + i, all = () => code.get(k);
    if (kind === AFFINE) return this.affine(a, b, null);
    if (kind === RATE) { code.get(kNumber); return this.of(a).multiply(); }
    if (kind === POWER) return this.powerCoefficient(a, out, this.first + i, all);
    if (kind > POWER) return this.sum(out - 1, b, all).get(kNumber).divide();
    if (kind === QUOTIENT) { this.of(a); this.sum(b, out, all).subtract(); return this.start(b).divide(); }
    if (kind === SQUARE) return this.square(a);
    this.sum(a, b, () => code.get(k).whole(-1).plus());
    this.of(a);
    this.start(b).multiply().add();
    this.start(a);
    return this.of(b).multiply().add();
  }

  exponent(constant) { return this.code.get(this.constants).load(NUMBER * constant); }
  positive(a) { return this.start(a).number(0).above(); }

  limit(constant) { // the limit of a power as its base goes to zero
    this.code.number(Infinity).number(0);
    return this.exponent(constant).number(0).below().choose();
  }

  powerValue(a, constant) {
    this.of(a).number(1).get(this.values + a).number(0).above().choose();
    this.exponent(constant).call(POWER_VALUE);
    this.limit(constant).get(this.values + a).number(0).above();
    return this.code.choose();
  }

  powerCoefficient(a, out, constant, all) { // 0 or the limit where there is no series, see hybrid/kernels/jets.py
    const { kNumber } = this;
    this.exponent(constant).number(1).add();
    this.sum(out - 1, out, all).multiply().get(kNumber);
    this.sum(a, out, all).multiply().subtract().get(kNumber);
    this.start(a).multiply().divide().number(0);
    this.hasSeries(a).choose();
    this.limit(constant);
    return this.positive(a).choose();
  }

  hasSeries(a) { // of the base, the curvature is not known yet at k = 1
    const { code, k, J, leastRatio, row } = this, size = (m) => code.get(J).load(row * a + m * NUMBER).absolute();
    code.get(k).whole(1).equal();
    this.start(a).get(leastRatio).get(leastRatio).multiply();
    size(2).multiply().above().or();
    this.start(a).get(leastRatio);
    return size(1).multiply().above().and();
  }

  square(a) { // coefficient k, with each pair of coefficients multiplied once
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

function tapesOf(structure) { // a tape for each mode
  const array = (name) => structure.arrays.find((each) => each.name === name);
  const read = (name) => { const { type, data } = array(`code.${name}`);
    return data ? Array.from(new KINDS[type](bytesOf(data).buffer), Number) : []; };
  const [ops, slots, ranges, flow] = ["ops", "term_slots", "mode_ops", "flow"].map(read);
  const inputs = structure.states.length, row = NUMBER * array("scratch.jets").shape[1];
  return structure.modes.map((_, mode) => {
    const [first, end] = [ranges[mode], ranges[mode + 1]];
    const operations = Array.from({ length: end - first }, (_, i) => ops.slice(3 * (first + i), 3 * (first + i + 1)));
    return { inputs, row, first, slots, flow: flow.slice(mode * inputs, (mode + 1) * inputs), ops: operations };
  });
}

async function compileJets({ exports }, structure) { // the index of each mode's code in the kernels' table
  const tapes = tapesOf(structure), names = tapes.map((_, mode) => `mode${mode}`);
  const functions = [writeSum(), writeLeastRatio(), ...tapes.map((tape) => new ModeWriter(tape).write())];
  const imports = [{ name: "memory" }, { name: "value", type: 0 }, { name: "power", type: POWER_TYPE }];
  const code = wasmModule({ types: JET_TYPES, imports, functions, exported: names });
  const { memory, frictionlab_function_value: value, frictionlab_power: power } = exports;
  const { instance } = await WebAssembly.instantiate(code, { kernels: { memory, value, power } });
  const table = exports.__indirect_function_table, first = table.grow(names.length);
  names.forEach((name, i) => table.set(first + i, instance.exports[name]));
  return BigInt64Array.from(names, (_, i) => BigInt(first + i));
}
