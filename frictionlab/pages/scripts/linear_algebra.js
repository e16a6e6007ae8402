// Equilibria by Newton's method, and eigenvalues by the QR algorithm on a Hessenberg matrix.
function solveLinear(A, b) { // Gaussian elimination with pivots; null where the matrix is singular
  const n = b.length, M = A.map((row, i) => [...row, b[i]]);
  for (let k = 0; k < n; k++) {
    let p = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(M[i][k]) > Math.abs(M[p][k])) p = i;
    [M[k], M[p]] = [M[p], M[k]];
    if (!(Math.abs(M[k][k]) > 1e-300)) return null;
    for (let i = k + 1; i < n; i++) {
      const f = M[i][k] / M[k][k];
      if (f) for (let j = k; j <= n; j++) M[i][j] -= f * M[k][j];
    }
  }
  const x = new Array(n);
  for (let i = n - 1; i >= 0; i--) {
    x[i] = M[i][n];
    for (let j = i + 1; j < n; j++) x[i] -= M[i][j] * x[j];
    x[i] /= M[i][i];
  }
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

function eigenvaluesOf(matrix) { // [[real, imaginary], ...], after EISPACK's balanc, elmhes and hqr
  const a = matrix.map((row) => [...row]), n = a.length, found = [];
  balance(a);
  hessenberg(a);
  let norm = 0;
  for (let i = 0; i < n; i++) for (let j = Math.max(i - 1, 0); j < n; j++) norm += Math.abs(a[i][j]);
  let last = n - 1, shift = 0, rounds = 0;
  while (last >= 0) {
    let l = last;
    for (; l >= 1; l--) {
      const s = Math.abs(a[l - 1][l - 1]) + Math.abs(a[l][l]) || norm;
      if (Math.abs(a[l][l - 1]) <= Number.EPSILON * s) { a[l][l - 1] = 0; break; }
    }
    const x = a[last][last];
    if (l === last) { found.push([x + shift, 0]); last--; rounds = 0; continue; }
    const y = a[last - 1][last - 1], w = a[last][last - 1] * a[last - 1][last];
    if (l === last - 1) {
      const p = 0.5 * (y - x), q = p * p + w, root = Math.sqrt(Math.abs(q)), base = x + shift;
      if (q >= 0) { const d = p + (p >= 0 ? root : -root);
        found.push([base + d, 0], [d ? base - w / d : base + d, 0]); }
      else found.push([base + p, root], [base + p, -root]);
      last -= 2;
      rounds = 0;
      continue;
    }
    if (rounds === 60) return null;
    shift = doubleStep(a, l, last, shift, rounds++);
  }
  return found;
}

function balance(a) { // scale rows and columns to similar size, by powers of two
  const n = a.length;
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
}

function hessenberg(a) {
  const n = a.length;
  for (let m = 1; m < n - 1; m++) {
    let p = m;
    for (let j = m; j < n; j++) if (Math.abs(a[j][m - 1]) > Math.abs(a[p][m - 1])) p = j;
    if (p !== m) { [a[p], a[m]] = [a[m], a[p]]; for (const row of a) [row[p], row[m]] = [row[m], row[p]]; }
    const pivot = a[m][m - 1];
    if (!pivot) continue;
    for (let i = m + 1; i < n; i++) {
      const f = a[i][m - 1] / pivot;
      if (!f) continue;
      for (let j = m - 1; j < n; j++) a[i][j] -= f * a[m][j];
      for (let j = 0; j < n; j++) a[j][m] += f * a[j][i];
      a[i][m - 1] = 0;
    }
  }
}

function doubleStep(a, l, last, shift, rounds) { // one QR step with two shifts; returns the sum of exceptional shifts
  const n = a.length;
  let x = a[last][last], y = a[last - 1][last - 1], w = a[last][last - 1] * a[last - 1][last];
  if (rounds % 10 === 9) {
    shift += x;
    for (let i = 0; i <= last; i++) a[i][i] -= x;
    const s = Math.abs(a[last][last - 1]) + Math.abs(a[last - 1][last - 2]);
    x = y = 0.75 * s;
    w = -0.4375 * s * s;
  }
  let m = last - 2, p, q, r;
  for (; m >= l; m--) {
    const z = a[m][m], u = x - z, v = y - z;
    p = (u * v - w) / a[m + 1][m] + a[m][m + 1];
    q = a[m + 1][m + 1] - z - u - v;
    r = a[m + 2][m + 1];
    const s = Math.abs(p) + Math.abs(q) + Math.abs(r);
    [p, q, r] = [p / s, q / s, r / s];
    if (m === l) break;
    const small = Math.abs(a[m][m - 1]) * (Math.abs(q) + Math.abs(r));
    if (small <= Number.EPSILON * Math.abs(p) * (Math.abs(a[m - 1][m - 1]) + Math.abs(z)
      + Math.abs(a[m + 1][m + 1]))) break;
  }
  for (let i = m; i < last - 1; i++) { a[i + 2][i] = 0; if (i !== m) a[i + 2][i - 1] = 0; }
  for (let k = m; k < last; k++) {
    if (k !== m) {
      [p, q, r] = [a[k][k - 1], a[k + 1][k - 1], k + 1 !== last ? a[k + 2][k - 1] : 0];
      x = Math.abs(p) + Math.abs(q) + Math.abs(r);
      if (x) [p, q, r] = [p / x, q / x, r / x];
    }
    const size = Math.sqrt(p * p + q * q + r * r), s = p >= 0 ? size : -size;
    if (!s) continue;
    if (k === m) { if (l !== m) a[k][k - 1] = -a[k][k - 1]; } else a[k][k - 1] = -s * x;
    p += s;
    const [fx, fy, fz] = [p / s, q / s, r / s];
    q /= p;
    r /= p;
    for (let j = k; j < n; j++) {
      const t = a[k][j] + q * a[k + 1][j] + (k + 1 !== last ? r * a[k + 2][j] : 0);
      if (k + 1 !== last) a[k + 2][j] -= t * fz;
      a[k + 1][j] -= t * fy;
      a[k][j] -= t * fx;
    }
    for (let i = 0; i <= Math.min(last, k + 3); i++) {
      const t = fx * a[i][k] + fy * a[i][k + 1] + (k + 1 !== last ? fz * a[i][k + 2] : 0);
      if (k + 1 !== last) a[i][k + 2] -= t * r;
      a[i][k + 1] -= t * q;
      a[i][k] -= t;
    }
  }
  return shift;
}
