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

// The sum of a[j] b[k - j] over 0 < j < k, as hybrid/kernels/jets.py: products of coefficients from below the block
// of four orders that k is in, in four partial sums that do not wait for each other, then those with one of the block.
function writeSum() { // function (a, b, k)
  const code = new Assembler(), [a, b, k, low, ahead, behind, older, newer] = [0, 1, 2, 3, 4, 5, 6, 7];
  const [first, second, total] = [8, 9, 10], known = [11, 12, 13, 14];
  const pairs = (sum, front, back) =>
    code.get(ahead).loadVector(front).get(behind).loadVector(back).get(behind).loadVector(back)
      .exchange().multiplyVectors().get(sum).addVectors().set(sum);
  const product = (front, back, sum) => code.get(front).load(0).get(back).load(0).multiply().get(sum).add().set(sum);
  const address = (array, number) => code.get(array).get(number).whole(NUMBER).times().plus();
  // the last order below the block
  const below = (array) => address(array, k).get(low).whole(-NUMBER).times().plus();
  code.get(k).whole(-1).plus().whole(3).and().whole(1).plus().set(low); // the place of k in its block, from 1
  below(a).set(ahead);
  address(b, low).set(behind);
  code.block().loop().get(ahead).get(a).whole(5 * NUMBER).plus().atLeast().isZero().branchIf(1);
  code.move(ahead, -3 * NUMBER);
  pairs(first, 2 * NUMBER, 0);
  pairs(second, 0, 2 * NUMBER);
  code.move(ahead, -NUMBER).move(behind, 4 * NUMBER).branch(0).end().end();
  known.forEach((sum, i) => code.get(i < 2 ? first : second).lane(1 - i % 2).set(sum));
  code.get(ahead).get(a).equal().isZero().if();
  known.forEach((sum, i) => { // orders 4, 3, 2, 1 of a, down to `low`
    code.whole(4 - i).get(low).atLeast().if();
    product(ahead, behind, sum);
    code.end().move(ahead, -NUMBER).move(behind, NUMBER);
  });
  code.end().get(known[0]).get(known[1]).add().get(known[2]).get(known[3]).add().add().set(total);
  below(a).whole(NUMBER).plus().set(ahead);
  address(b, low).whole(-NUMBER).plus().set(behind);
  address(a, low).whole(-NUMBER).plus().set(older);
  below(b).whole(NUMBER).plus().set(newer);
  code.block().loop().get(low).whole(2).atLeast().isZero().branchIf(1);
  product(ahead, behind, total);
  code.get(k).whole(5).atLeast().if();
  product(older, newer, total);
  code.end().move(ahead, NUMBER).move(behind, -NUMBER).move(older, -NUMBER).move(newer, NUMBER).move(low, -1);
  return { type: 1, locals: [[5, i32], [2, v128], [5, f64]], code: code.branch(0).end().end().get(total) };
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
      this.leastRatio, this.values] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
  }

  write() {
    const { code, inputs, z, J, k, kNumber, column, last, order, share, flow } = this;
    for (let i = 0; i < inputs; i++) this.put(J, i, () => code.get(z).load(NUMBER * i));
    this.ops.forEach((op, i) => this.put(J, inputs + i, () => this.value(i, ...op)));
    code.get(order).wrap().keep(last).isZero().if().return().end();
    if (this.ops.some(([kind]) => kind === POWER)) code.get(last).asNumber().call(LEAST_RATIO).set(this.leastRatio);
    code.whole(1).set(k).number(1).set(kNumber).get(J).whole(NUMBER).plus().set(column).loop();
    code.number(1).get(kNumber).divide().set(share);
    const rate = (i) => code.get(column).whole(this.row * flow[i] - NUMBER).plus().load(0); // coefficient k - 1
    for (let i = 0; i < inputs; i++) this.put(column, i, () => rate(i).get(share).multiply());
    this.ops.forEach((op, i) => this.put(column, inputs + i, () => this.coefficient(i, ...op)));
    code.get(k).get(last).equal().if().return().end();
    code.move(k, 1).move(column, NUMBER).get(kNumber).number(1).add().set(kNumber).branch(0).end();
    return { type: MODE_TYPE, locals: [[3, i32], [3 + inputs + this.ops.length, f64]], code };
  }

  put(at, slot, write) { // store a value in its local and in its row of the jets
    this.code.get(at);
    write();
    this.code.keep(this.values + slot).store(this.row * slot);
  }

  of(slot) { return this.code.get(this.values + slot); } // the coefficient of the present order
  start(slot) { return this.code.get(this.J).load(this.row * slot); }

  sum(a, b) { // the sum of a[j] b[k - j] over 0 < j < k
    for (const slot of [a, b]) this.code.get(this.J).whole(this.row * slot).plus();
    return this.code.get(this.k).call(SUM);
  }

  sumWithLast(a, b) { // over 0 < j <= k
    this.sum(a, b);
    this.of(a);
    return this.start(b).multiply().add();
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
    const { code, kNumber } = this, out = this.inputs + i;
    if (kind === AFFINE) return this.affine(a, b, null);
    if (kind === RATE) { code.get(kNumber); return this.of(a).multiply(); }
    if (kind === POWER) return this.powerCoefficient(a, out, this.first + i);
    if (kind > POWER) return this.sumWithLast(out - 1, b).get(kNumber).divide();
    if (kind === QUOTIENT) { this.of(a); this.sumWithLast(b, out).subtract(); return this.start(b).divide(); }
    if (kind === SQUARE) return this.square(a);
    this.sumWithLast(a, b);
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

  powerCoefficient(a, out, constant) { // 0 or the limit where there is no series, see hybrid/kernels/jets.py
    const { kNumber } = this;
    this.exponent(constant).number(1).add();
    this.sumWithLast(out - 1, out).multiply().get(kNumber);
    this.sumWithLast(a, out).multiply().subtract().get(kNumber);
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

  square(a) {
    this.sum(a, a).number(2);
    this.start(a).multiply();
    return this.of(a).multiply().add();
  }
}

function tapesOf(structure) { // a tape for each mode
  const array = (name) => structure.arrays.find((each) => each.name === name);
  const read = (name) => { const { type, data, shape } = array(`code.${name}`); // without data all are zero
    return data ? Array.from(new KINDS[type](bytesOf(data).buffer), Number)
      : Array(shape.reduce((x, y) => x * y, 1)).fill(0); };
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
