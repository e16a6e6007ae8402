// A state near an equilibrium, from which runs start "near" it, by the rules of
// frictionlab/stability/eigenproblems/displaced_equilibrium.py: coordinates one percent off or, where that leaves the
// mode that grows fastest at rest, this mode.
const DISPLACEMENT = 0.01, SEEN_SHARE = 1e-9, NEGLIGIBLE_SHARE = 1e-6, NONLINEAR_SHARE = 0.5;
const COMPLETING_STEPS = 4, ANGLES = 16, SIZE_DECADES = 40, SIZES_PER_DECADE = 4;

const sizesOf = ([real, imaginary]) => real.map((v, i) => Math.hypot(v, imaginary[i]));
const scalar = (vector, x) => vector.map((part) => part.reduce((sum, v, i) => sum + v * x[i], 0)); // of a real x

function displacedEquilibrium(known, values, n) { // n: how many states are displaced
  const { z, sliding } = known, percent = z.map((v, i) => (i < n ? (1 + DISPLACEMENT) * v : v));
  const near = completed(sliding, percent, values);
  const mode = leastStableMode(known, values);
  if (!mode || z.slice(0, n).some(Boolean) && mode.growth <= 0) return near;
  const size = linearSize(known, values, mode), shift = near.map((v, i) => v - z[i]);
  if (isExcited(mode, shift, size)) return near;
  const sizes = sizesOf(mode.right), shown = largest([sizes.slice(0, n)]) ? sizes.slice(0, n) : sizes;
  const least = (1 - SEEN_SHARE) * largest([shown]), place = shown.findLastIndex((v) => v >= least);
  const turn = Math.atan2(mode.right[1][place], mode.right[0][place]);
  const step = along(mode, DISPLACEMENT * (size === Infinity ? 1 : size), -turn);
  return completed(sliding, near.map((v, i) => v + step[i]), values);
}

function completed({ following, flow }, state, values) { // with the states that follow from the others
  for (let round = 0; round < COMPLETING_STEPS && following.length; round++) {
    const rates = flow(state, values);
    state = state.map((v, i) => (following.includes(i) ? v + rates[i] : v));
  }
  return state;
}

function leastStableMode({ z, sliding: { following, jacobian } }, values) { // with both of its vectors, or null
  const m = z.length, flat = jacobian(z, values), matrix = z.map((_, i) => flat.slice(i * m, i * m + m));
  const kept = z.map((_, i) => i).filter((i) => !following.includes(i));
  const reduced = kept.map((i) => kept.map((j) => matrix[i][j]));
  const growth = ([re, im]) => (Math.abs(re) > ROUNDING * Math.hypot(re, im) ? re : 0);
  const [value] = (eigenvaluesOf(reduced) ?? []).sort((a, b) =>
    growth(b) - growth(a) || Math.abs(b[1]) - Math.abs(a[1]));
  if (!value) return null;
  const whole = (vector, follow) => vector.map((part) =>
    z.map((_, i) => (kept.includes(i) ? part[kept.indexOf(i)] : follow(part, i))));
  const left = whole(eigenvector(kept.map((_, j) => reduced.map((row) => row[j])), value), () => 0);
  const right = whole(eigenvector(reduced, value), (part, i) =>
    kept.reduce((sum, j, k) => sum + matrix[i][j] * part[k], 0));
  const [[rr, ir], [ri, ii]] = right.map((part) => scalar(left, part));
  const product = Math.hypot(rr - ii, ir + ri);
  return { matrix, left, right, growth: growth(value), rate: Math.hypot(...value), product };
}

function eigenvector(matrix, [re, im]) { // [real part, imaginary part], its largest entry of size 1; inverse iteration
  const m = matrix.length, a = re + 1e-10 * Math.hypot(re, im);
  const diagonal = (v) => matrix.map((_, i) => matrix.map((_, j) => (i === j ? v : 0)));
  const shifted = matrix.map((row, i) => row.map((v, j) => (i === j ? v - a : v)));
  const joined = (one, other) => one.map((row, i) => [...row, ...other[i]]);
  const both = [...joined(shifted, diagonal(im)), ...joined(diagonal(-im), shifted)]; // of real and imaginary part
  const factors = new mlMatrix.LU(both);
  let x = both.map((_, i) => Math.cos(i));
  for (let round = 0; round < 4; round++) {
    x = factors.solve(mlMatrix.Matrix.columnVector(x)).to1DArray();
    const size = largest([sizesOf([x.slice(0, m), x.slice(m)])]);
    x = x.map((v) => v / size);
  }
  return [x.slice(0, m), x.slice(m)];
}

const along = ({ right: [real, imaginary] }, size, angle) =>
  real.map((v, i) => size * (v * Math.cos(angle) - imaginary[i] * Math.sin(angle)));

function isExcited({ left, product }, shift, size) { // whether a displacement has a part along the mode that counts
  const part = Math.hypot(...scalar(left, shift)), sizes = sizesOf(left);
  if (part <= SEEN_SHARE * shift.reduce((sum, v, i) => sum + Math.abs(v) * sizes[i], 0)) return false;
  return size === Infinity || part > NEGLIGIBLE_SHARE * DISPLACEMENT * size * product;
}

// the end of the widest range of sizes at which the mode's motion is linear and meets no event
function linearSize({ z, sliding: { flow, guards } }, values, mode) {
  const { matrix, left, rate, product } = mode;
  const directions = Array.from({ length: ANGLES }, (_, k) => along(mode, 1, 2 * Math.PI * k / ANGLES))
    .filter((way) => largest([way]) > NONLINEAR_SHARE); // those of a real mode may vanish
  const isLinear = (size) => directions.every((way) => {
    const shift = way.map((v) => size * v), at = z.map((v, i) => v + shift[i]);
    const bent = flow(at, values).map((v, i) => v - matrix[i].reduce((sum, a, j) => sum + a * shift[j], 0));
    return Math.hypot(...scalar(left, bent)) < NONLINEAR_SHARE * rate * product * size
      && guards(at, values).every((g) => g > 0);
  });
  const ends = SIZES_PER_DECADE * SIZE_DECADES,
    sizes = Array.from({ length: 2 * ends + 1 }, (_, k) => 10 ** ((k - ends) / SIZES_PER_DECADE));
  let [longest, count, found] = [0, 0, Infinity];
  for (const [k, size] of sizes.entries()) {
    count = isLinear(size) ? count + 1 : 0;
    if (count > longest) [longest, found] = [count, sizes[k + 1] ?? Infinity];
  }
  return found;
}
