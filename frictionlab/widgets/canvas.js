// A model's mechanism, its contact forces and its phase plane, played in a notebook. Python sends the sizes once as `scene`
// and the places as `rows`: 32-bit numbers, one row for every frame, with the columns of scene.columns.  What draws them
// stands in frictionlab/plotting/animation/drawing.js, which canvas.py puts before this.  Colours are those of the style
// in which it was made.
const PACES = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

function render({ model, el }) {
  const scene = model.get("scene"), view = model.get("rows"), columns = scene.columns;
  const numbers = new Float32Array(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
  const get = (i, name) => numbers[i * columns.length + columns.indexOf(name)];
  const frames = { count: numbers.length / columns.length, get };
  const style = "flex: 1 1 300px; min-width: 0; height: 340px;";
  const pictures = [0, 1].map(() => html("canvas", { style }));
  const play = html("button", { textContent: "play", style: "width: 5em" });
  const scrub = html("input", { type: "range", min: 0, max: frames.count - 1, value: 0, style: "flex: 1 1 120px; min-width: 0", ariaLabel: "time" });
  const times = (factor) => `${+factor.toPrecision(3)} times`;
  const named = (pace) => (pace === 1 ? "real time" : pace > 1 ? `${times(pace)} faster` : `${times(1 / pace)} slower`);
  const paces = [...new Set([...PACES, scene.speed])].sort((a, b) => b - a);
  const pace = html("select", { ariaLabel: "pace" }, paces.map((p) => html("option", { value: p, textContent: named(p), selected: p === scene.speed })));
  const state = html("span", { style: "width: 100%; font-variant-numeric: tabular-nums" });
  const key = scene.legend.map(([text, colour]) => html("span", { style: "white-space: nowrap" },
    [html("span", { style: `display: inline-block; width: 1em; height: 0.7em; margin-right: 0.3em; background: ${colour}` }), ...subscripted(text)]));
  const bar = (nodes) => html("div", { style: "display: flex; flex-wrap: wrap; gap: 4px 14px; align-items: center; margin: 4px" }, nodes);
  el.append(html("div", { style: `background: ${scene.paper}; color: ${scene.ink}; font: 13px sans-serif; padding: 4px` },
    [bar([play, scrub, pace, state]), html("div", { style: "display: flex; flex-wrap: wrap" }, pictures), bar(key)]));

  let time = 0, last = null, request = null, path = null, place = null, surfaces = null;
  function show() {
    if (!surfaces) return;
    const frame = Math.min(frames.count - 1, Math.floor(time / scene.step + 1e-6)), now = Object.fromEntries(columns.map((name) => [name, get(frame, name)]));
    const [[c, w, h], [p, pw, ph]] = surfaces;
    c.clearRect(0, 0, w, h);
    now.all = numbers.subarray(frame * columns.length, (frame + 1) * columns.length);
    (scene.shapes ? shapes : mechanism)(c, w, h, scene, now);
    p.clearRect(0, 0, pw, ph);
    p.drawImage(path, 0, 0, pw, ph);
    p.beginPath();
    p.arc(...place(now), 6, 0, 7);
    Object.assign(p, { fillStyle: scene.colours[now.mode], strokeStyle: scene.ink, lineWidth: 1.5 });
    p.fill();
    p.stroke();
    scrub.value = frame;
    state.textContent = `t = ${(scene.start + frame * scene.step).toFixed(scene.digits)} s: ${scene.modes[now.mode]}; ${scene.note}`;
  }
  function resize() {
    if (!pictures.every((canvas) => canvas.clientWidth)) return;
    surfaces = pictures.map(fit);
    const [, width, height] = surfaces[1];
    path = html("canvas", { width: pictures[1].width, height: pictures[1].height });
    const c = path.getContext("2d");
    c.scale(path.width / width, path.height / height);
    place = phasePlane(c, width, height, scene, frames);
    show();
  }
  function tick(now) {
    if (last !== null) time = (time + (now - last) / 1000 * Number(pace.value)) % (frames.count * scene.step);
    last = now;
    show();
    request = requestAnimationFrame(tick);
  }
  function toggle() {
    if (request !== null) { cancelAnimationFrame(request); request = last = null; } else request = requestAnimationFrame(tick);
    play.textContent = request === null ? "play" : "pause";
  }
  play.onclick = toggle;
  scrub.oninput = () => { time = Number(scrub.value) * scene.step; show(); };
  const observer = new ResizeObserver(resize);
  observer.observe(pictures[0]);
  return () => { observer.disconnect(); cancelAnimationFrame(request); };
}

export default { render };
