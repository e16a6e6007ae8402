// Samples of a run by its dense output, and the outputs of its modes.
function sampleTimes(start, stop, count) {
  return Float64Array.from({ length: count }, (_, i) => i === count - 1 ? stop : start + (stop - start) * i / (count - 1));
}

function sample(solver, run, times, outputs = run.structure.outputs) { // states, modes and outputs at ascending times, of which there are at most SAMPLES
  const { arrays } = solver, n = run.structure.states.length, { names, functions } = outputs;
  const modes = new Int32Array(times.length), which = arrays.which.view;
  for (let i = 0, step = 0; i < times.length; i++) {
    while (step + 1 < run.steps && run.stepTimes[2 * step + 2] <= times[i]) step++;
    which[i] = BigInt(step);
    modes[i] = Number(run.stepModes[step]);
  }
  arrays.times.view.set(times);
  const cut = (a, columns) => ({ place: a.place, shape: columns ? [times.length, columns] : [times.length] }), made = solver.structure.arrays;
  const shape = (name, width) => ({ place: arrays[name].place, shape: width ? [run.steps, width] : [run.steps] });
  if (made && run.steps) solver.call("sample_states", {
    "steps.times": shape("record.step_times", 2), "steps.modes": shape("record.step_modes"), "steps.states": shape("record.step_states", n),
    which: cut(arrays.which), times: cut(arrays.times), out: cut(arrays.out, n), J: arrays["scratch.jets"],
  });
  const states = arrays.out.view.slice(0, n * times.length);
  const columns = run.structure.states.map((_, j) => Float64Array.from(times, (_, i) => states[i * n + j]));
  const values = names.map(() => new Float64Array(times.length));
  for (let i = 0; names.length && i < times.length; i++) {
    const found = outputsAt(run, modes[i], states.subarray(i * n, i * n + n));
    for (let k = 0; k < names.length; k++) values[k][i] = found[k];
  }
  const byName = Object.fromEntries([...run.structure.states.map((name, j) => [name, columns[j]]), ...names.map((name, k) => [name, values[k]])]);
  return { times, modes, byName, column: (name) => byName[name] };

  function outputsAt({ structure, values: parameters }, mode, state) {
    try { return functions[mode](state, parameters); } catch { return structure.outputs.names.map(() => NaN); }
  }
}

const NO_OUTPUTS = { names: [], functions: [] };

function amplitudes(signal) { // one-sided amplitudes of a real signal of 2^k samples without its mean, with a Hann window
  const n = signal.length, mean = signal.reduce((a, b) => a + b, 0) / n;
  const re = Float64Array.from(signal, (v, i) => (v - mean) * (1 - Math.cos(2 * Math.PI * i / n))), im = new Float64Array(n);
  for (let i = 1, j = 0; i < n; i++) { // reorder: bits of the indices reversed
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) [re[i], re[j]] = [re[j], re[i]];
  }
  for (let size = 2; size <= n; size *= 2) {
    for (let k = 0; k < size / 2; k++) {
      const [c, s] = [Math.cos(2 * Math.PI * k / size), -Math.sin(2 * Math.PI * k / size)];
      for (let i = k; i < n; i += size) {
        const j = i + size / 2, x = re[j] * c - im[j] * s, y = re[j] * s + im[j] * c;
        [re[j], im[j]] = [re[i] - x, im[i] - y];
        re[i] += x;
        im[i] += y;
      }
    }
  }
  return Float64Array.from({ length: n / 2 }, (_, i) => 2 * Math.hypot(re[i], im[i]) / n);
}
