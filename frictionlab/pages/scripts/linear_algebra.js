// Equilibria by Newton's method, and eigenvalues; ml-matrix solves equations and finds the eigenvalues.
function solveLinear(matrix, b) { // null where the matrix is singular
  const factors = new mlMatrix.LU(matrix);
  const x = factors.isSingular() ? [NaN] : factors.solve(mlMatrix.Matrix.columnVector(b)).to1DArray();
  return x.every(Number.isFinite) ? x : null;
}

function newton({ flow, jacobian }, start, values) { // a state at which the flow vanishes, or null
  let z = [...start];
  const n = z.length, size = (v) => Math.hypot(...v);
  try {
    for (let round = 0; round < 60; round++) {
      const f = flow(z, values), flat = jacobian(z, values);
      const change = solveLinear(Array.from({ length: n }, (_, i) => flat.slice(i * n, i * n + n)), f.map((v) => -v));
      if (!change) return null;
      let share = 1;
      for (; share > 1e-3; share /= 2) if (size(flow(z.map((v, i) => v + share * change[i]), values)) <= size(f)) break;
      z = z.map((v, i) => v + share * change[i]);
      if (size(change) <= 1e-13 * (size(z) + 1e-12)) return z;
    }
  } catch { return null; }
  return null;
}

// {z, sliding}: in a mode without constraints, where all its event functions are positive; or null
function equilibriumOf(structure, values, starts) {
  for (const sliding of structure.sliding) {
    for (const start of starts) {
      const z = newton(sliding, start, values);
      if (!z) continue;
      try {
        const inside = sliding.guards(z, values).every((g) => g > 0);
        if (inside && contactHolds(structure, sliding.mode, z, values)) return { z, sliding };
      } catch {} // a formula without a value there
    }
  }
  return null;
}

function contactHolds(structure, mode, z, values) { // in slip the normal force is positive
  const place = structure.outputs.names.indexOf("normal_force");
  return place < 0 || !structure.modes[mode].startsWith("slip")
    || structure.outputs.functions[mode](z, values)[place] > 0;
}

function eigenvaluesAt({ z, sliding }, values) {
  const flat = sliding.jacobian(z, values), n = z.length;
  const kept = Array.from({ length: n }, (_, i) => i).filter((i) => !sliding.following.includes(i));
  return eigenvaluesOf(kept.map((i) => kept.map((j) => flat[i * n + j])));
}

function eigenvaluesOf(matrix) { // [[real, imaginary], ...], or null where an entry has no value
  if (!matrix.flat().every(Number.isFinite)) return null;
  const found = new mlMatrix.EVD(balanced(matrix));
  return found.realEigenvalues.map((re, i) => [re, found.imaginaryEigenvalues[i]]);
}

function balanced(matrix) { // with rows and columns scaled to similar size, by powers of two
  const a = matrix.map((row) => [...row]), n = a.length;
  for (let done = false; !done;) {
    done = true;
    for (let i = 0; i < n; i++) {
      let [r, c] = [0, 0];
      for (let j = 0; j < n; j++) if (j !== i) { c += Math.abs(a[j][i]); r += Math.abs(a[i][j]); }
      if (!c || !r) continue;
      const f = 2 ** Math.round(Math.log2(r / c) / 2);
      if ((c * f + r / f) < 0.95 * (c + r)) {
        done = false;
        for (let j = 0; j < n; j++) a[i][j] /= f;
        for (let j = 0; j < n; j++) a[j][i] *= f;
      }
    }
  }
  return a;
}
