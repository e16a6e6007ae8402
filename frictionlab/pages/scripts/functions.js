// Functions of parameters as Python computes them: integer powers are products, all else calls of the kernels.
const F = {};

F.integer_power = (x, n) => { // by repeated squaring, from the exponent's lowest bit
  let value = 1, square = x;
  for (let count = Math.abs(n); count; count = Math.floor(count / 2)) {
    if (count % 2) value *= square;
    square *= square;
  }
  return n >= 0 ? value : 1 / value;
};

function bindFunctions(solver) {
  F.real_power = (x, y) => Number.isInteger(y) ? F.integer_power(x, y) : solver.exports.frictionlab_power(x, y);
  for (const [name, kind] of Object.entries(SCENE.method.kinds)) F[name] = (x) =>
    solver.exports.frictionlab_function_value(BigInt(kind), x);
  for (const name of SCENE.method.elementary) F[name] = (x) => solver.exports[`frictionlab_${name}`](x);
}
