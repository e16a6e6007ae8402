// Samples of a run by its dense output, and the outputs of its modes.
const NO_OUTPUTS = { names: [], functions: [] };

function sampleTimes(start, stop, count) {
  return Float64Array.from({ length: count },
    (_, i) => i === count - 1 ? stop : start + (stop - start) * i / (count - 1));
}

// states, modes and outputs at ascending times, of which there are at most SAMPLES
function sample(solver, run, times, outputs = run.structure.outputs) {
  const { arrays } = solver, n = run.structure.states.length, modes = new Int32Array(times.length),
    which = arrays.which.view;
  for (let i = 0, step = 0; i < times.length; i++) {
    while (step + 1 < run.steps && run.stepTimes[2 * step + 2] <= times[i]) step++;
    which[i] = BigInt(step);
    modes[i] = Number(run.stepModes[step]);
  }
  arrays.times.view.set(times);
  const cut = (a, columns) => ({ place: a.place, shape: columns ? [times.length, columns] : [times.length] });
  const shape = (name, width) => ({ place: arrays[name].place, shape: width ? [run.steps, width] : [run.steps] });
  if (run.steps) solver.call("sample_states", {
    "steps.times": shape("record.step_times", 2), "steps.modes": shape("record.step_modes"),
      "steps.states": shape("record.step_states", n),
    which: cut(arrays.which), times: cut(arrays.times), out: cut(arrays.out, n), J: arrays["scratch.jets"],
  });
  const states = arrays.out.view.slice(0, n * times.length);
  for (let i = times.length - 1; i >= 0 && times[i] >= run.end; i--) { // at its end, what the run ended with
    states.set(run.state, i * n);
    modes[i] = run.mode;
  }
  return samplesOf(run, times, modes, states, outputs);
}

// {times, modes, byName, column}
function samplesOf({ structure, values }, times, modes, states, { names, functions }) {
  const n = structure.states.length,
    columns = structure.states.map((_, j) => Float64Array.from(times, (_, i) => states[i * n + j]));
  const found = names.map(() => new Float64Array(times.length));
  for (let i = 0; names.length && i < times.length; i++) {
    let here;
    try { here = functions[modes[i]](states.subarray(i * n, i * n + n), values);
    } catch { here = names.map(() => NaN); }
    here.forEach((v, k) => { found[k][i] = v; });
  }
  return samplesByName(times, modes, [...structure.states, ...names], [...columns, ...found]);
}

// Samples at equal distances and, on both sides of each event, what jumps there; without the latter where they are
// many.
function sampleWithEvents(solver, run, start, stop, count) {
  const n = run.structure.states.length, inside = [], uniform = sampleTimes(start, stop, count);
  for (let i = 0; i < run.events;
    i++) if (run.eventTimes[i] > start && run.eventTimes[i] < stop
    && run.eventTimes[i] !== run.eventTimes[i - 1]) inside.push(i);
  if (!inside.length || inside.length > count) return sample(solver, run, uniform);
  const times = Float64Array.from([...uniform, ...inside.map((i) => run.eventTimes[i])]).sort(),
    after = sample(solver, run, times);
  const rows = times.length + inside.length,
    all = { times: new Float64Array(rows), modes: new Int32Array(rows), states: new Float64Array(rows * n) };
  for (let i = 0, row = 0, event = 0; i < times.length; i++, row++) {
    if (event < inside.length && times[i] === run.eventTimes[inside[event]]) { // before it
      all.times[row] = times[i];
      all.modes[row] = all.modes[row - 1];
      all.states.set(run.eventStates.subarray(2 * n * inside[event], 2 * n * inside[event] + n), row * n);
      event++;
      row++;
    }
    all.times[row] = times[i];
    all.modes[row] = after.modes[i];
    for (let j = 0; j < n; j++) all.states[row * n + j] = after.byName[run.structure.states[j]][i];
  }
  return samplesOf(run, all.times, all.modes, all.states, run.structure.outputs);
}

// one-sided amplitudes of a real signal of 2^k samples without its mean, with a Hann window
function amplitudes(signal) {
  const n = signal.length, mean = signal.reduce((a, b) => a + b, 0) / n;
  const re = Float64Array.from(signal, (v, i) => (v - mean) * (1 - Math.cos(2 * Math.PI * i / n))),
    im = new Float64Array(n);
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
