// The instructions of WebAssembly that jets.js needs, as bytes; see https://webassembly.github.io/spec/core/binary.
const KIND = { i32: 0x7f, i64: 0x7e, f64: 0x7c, v128: 0x7b };
const NUMBER = 8, ALIGNED = 3; // bytes of a number, and log2 of the alignment of its address
const PLAIN = {
  loop: [0x03, 0x40], block: [0x02, 0x40], if: [0x04, 0x40], end: [0x0b], return: [0x0f],
  // of i32
  isZero: [0x45], equal: [0x46], atLeast: [0x4e], plus: [0x6a], times: [0x6c], and: [0x71], or: [0x72],
    wrap: [0xa7],
  add: [0xa0], subtract: [0xa1], multiply: [0xa2], divide: [0xa3], // of f64
  // choose: the first of two values if a third is not 0, else the second
  absolute: [0x99], below: [0x63], above: [0x64], choose: [0x1b],
  asNumber: [0xb7], bits: [0xbd], fromBits: [0xbf], addLong: [0x7c], shiftLongLeft: [0x86],
  addVectors: [0xfd, 0xf0, 0x01], multiplyVectors: [0xfd, 0xf2, 0x01],
    exchange: [0xfd, 0x0d, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7],
};

function unsigned(value) { // LEB128
  const bytes = [];
  for (; value > 127; value >>>= 7) bytes.push(value & 127 | 128);
  return [...bytes, value];
}

function signed(value) {
  const bytes = [];
  for (; value < -64 || value > 63; value >>= 7) bytes.push(value & 127 | 128);
  return [...bytes, value & 127];
}

class Assembler { // the instructions of a function, one after another
  constructor() { this.bytes = []; }

  put(...bytes) { for (const byte of bytes) this.bytes.push(byte); return this; }
  get(local) { return this.put(0x20, ...unsigned(local)); }
  set(local) { return this.put(0x21, ...unsigned(local)); }
  keep(local) { return this.put(0x22, ...unsigned(local)); } // set, and leave the value on the stack
  whole(value) { return this.put(0x41, ...signed(value)); }
  long(value) { return this.put(0x42, ...signed(value)); }
  number(value) { return this.put(0x44, ...new Uint8Array(Float64Array.of(value).buffer)); }
  load(offset) { return this.put(0x2b, ALIGNED, ...unsigned(offset)); }
  store(offset) { return this.put(0x39, ALIGNED, ...unsigned(offset)); }
  loadVector(offset) { return this.put(0xfd, 0x00, ALIGNED, ...unsigned(offset)); }
  lane(number) { return this.put(0xfd, 0x21, number); }
  call(number) { return this.put(0x10, ...unsigned(number)); }
  branch(depth) { return this.put(0x0c, depth); }
  branchIf(depth) { return this.put(0x0d, depth); }
  move(local, bytes) { return this.get(local).whole(bytes).plus().set(local); } // an address or a count
}

for (const [name, bytes] of Object.entries(PLAIN)) {
  Assembler.prototype[name] = function () { return this.put(...bytes); };
}

function wasmModule({ types, imports, functions, exported }) { // functions: {type, locals: [[count, kind], ...], code}
  const list = (items) => [...unsigned(items.length), ...items.flat()],
    sized = (bytes) => [...unsigned(bytes.length), ...bytes];
  const text = (name) => sized([...new TextEncoder().encode(name)]),
    calls = imports.filter(({ type }) => type !== undefined).length;
  // a memory or a function
  const imported = ({ name, type }) =>
    [...text("kernels"), ...text(name), ...(type === undefined ? [0x02, 0x00, 0x00] : [0x00, ...unsigned(type)])];
  const body = ({ locals, code }) =>
    sized([...list(locals.map(([count, kind]) => [...unsigned(count), kind])), ...code.bytes, 0x0b]);
  const sections = [
    [1, list(types.map(([given, made]) => [0x60, ...sized(given), ...sized(made)]))],
    [2, list(imports.map(imported))],
    [3, list(functions.map(({ type }) => unsigned(type)))],
    // the last functions
    [7, list(exported.map((name, i) =>
      [...text(name), 0x00, ...unsigned(calls + functions.length - exported.length + i)]))],
    [10, list(functions.map(body))],
  ];
  return Uint8Array.from([0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00,
    ...sections.flatMap(([number, content]) => [number, ...sized(content)])]);
}
