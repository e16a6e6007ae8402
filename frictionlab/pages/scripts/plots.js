// Plots by uPlot in the colours of the page; each is made once and given new data.
const plots = {};
const LEGEND = 2.3; // height of the legend under a plot, in font sizes

const letters = () => parseFloat(getComputedStyle(document.body).fontSize); // font size in pixels; larger on a large screen
const px = (share) => Math.round(share * letters());

function seriesColours() {
  const { ink, force } = theme();
  return [ink, COLOURS.vermillion, force, COLOURS.green, COLOURS.orange, COLOURS.purple];
}

const isDecade = (v) => v && Number.isInteger(Math.log10(v));
const onlyDecades = (_, ticks) => ticks.map((v) => isDecade(v) ? v : null);

function axisOptions(label, log) {
  const { ink, grey } = theme(), filter = log ? { filter: onlyDecades } : {};
  return {
    label, stroke: ink, grid: { stroke: grey + "40", width: 1, ...filter }, ticks: { stroke: grey, width: 1, ...filter },
    labelSize: px(1.2), labelGap: 0, font: `${px(0.75)}px system-ui`, labelFont: `${px(0.8)}px system-ui`,
    ...(log ? { values: (_, ticks) => ticks.map((v) => isDecade(v) ? v.toExponential(0) : "") } : {}),
  };
}

function showPlot(id, data, names, [xLabel, yLabel], options = {}) {
  const host = document.getElementById(id), key = JSON.stringify([names, xLabel, yLabel, letters()]);
  if (plots[id]?.key !== key) {
    plots[id]?.chart.destroy();
    const points = options.points, width = host.clientWidth || 300, height = host.clientHeight - (points ? 0 : px(LEGEND));
    const series = names.map((label, i) => ({ label, stroke: seriesColours()[i % 6], width: 1, ...(points ? { paths: () => null, points: { show: true, size: 8, fill: seriesColours()[i % 6] } } : { points: { show: false } }) }));
    const y = options.log ? { distr: 3 } : {};
    plots[id] = { key, chart: new uPlot({ width, height, series: [{ label: xLabel }, ...series], scales: { x: { time: false }, y }, axes: [{ ...axisOptions(xLabel), size: px(2.1) }, { ...axisOptions(yLabel, options.log), size: px(3.5) }], legend: { show: !points, live: false }, cursor: { drag: { x: true, y: false } } }, data, host) };
  } else plots[id].chart.setData(data);
}

function forgetPlots() { // so that they are made again, in other colours
  for (const id of Object.keys(plots)) { plots[id].chart.destroy(); delete plots[id]; }
}

function resizePlots() {
  for (const [id, { chart }] of Object.entries(plots)) {
    const host = document.getElementById(id), legend = host.querySelector(".u-legend") ? px(LEGEND) : 0;
    chart.setSize({ width: host.clientWidth, height: host.clientHeight - legend });
  }
}

const unitOf = (name) => /^(phi|theta|alpha)/.test(name) ? "rad" : "m";
const SUBSCRIPTS = "₀₁₂₃₄₅₆₇₈₉";
const written = (name) => name.replace(/[0-9]/g, (d) => SUBSCRIPTS[d]).replace("'", "′").replace("phi", "φ");

function showHistory(run, samples) {
  const shown = run.structure.states.slice(0, run.structure.coordinates).slice(0, 6);
  showPlot("history", [samples.times, ...shown.map(samples.column)], shown.map((name) => written(name) + (unitOf(name) === "m" ? "" : " (rad)")), ["time (s)", "displacement (m)"]);
}

const forceName = (name) => written(name.replace("normal_force", "normal").replace("friction_force", "friction").replace("_", " "));

function showForces(run, samples) {
  const shown = run.structure.outputs.names.filter((name) => /^(normal_force|friction_force|reaction)/.test(name)).slice(0, 6);
  document.getElementById("forces").parentElement.hidden = !shown.length;
  if (shown.length) showPlot("forces", [samples.times, ...shown.map(samples.column)], shown.map(forceName), ["time (s)", "force (N)"]);
}

function showSpectrum(run, signal, step) {
  const found = amplitudes(signal), count = found.length, hertz = Float64Array.from(found, (_, i) => i / (2 * count * step));
  const end = Math.max(8, hertz.findIndex((f) => f > 20 / SCENE.period)), cut = end > 8 ? end : count;
  const positive = Array.from(found.subarray(1, cut), (v) => v > 1e-16 ? v : 1e-16);
  showPlot("spectrum", [hertz.slice(1, cut), positive], [written(run.structure.states[0])], ["frequency (Hz)", `amplitude (${unitOf(run.structure.states[0])})`], { log: true });
}

function showEigenvalues(values, caption) {
  document.getElementById("stability").textContent = caption;
  const sorted = [...values].sort((a, b) => a[0] - b[0]);
  showPlot("eigenvalues", [sorted.map(([re]) => re), sorted.map(([, im]) => im / (2 * Math.PI))], ["eigenvalues"], ["growth rate (1/s)", "frequency (Hz)"], { points: true });
}

function phaseFrames(run, samples) {
  const coordinate = run.structure.states[0], rate = coordinate + "'";
  const get = (i, name) => name === "mode" ? samples.modes[i] : samples.column(name === "rate" ? rate : name)[i];
  return { count: samples.times.length, get };
}
