// A model's mechanism, its contact forces and its phase plane, played in a notebook. Python sends the sizes as `scene` and
// the places as `rows`: 32-bit numbers, one row for every frame, with the columns of scene.columns.  An explorer sends new
// ones when its controls move, while this plays on.  The functions that draw are those of drawing.js in
// frictionlab/plotting/animation, which canvas.py puts before this file.  Colours are those of the style in which the scene
// was made.
const PACES = [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01];
const LABEL = 13; // font size in pixels, unless the page sets one

function render({ model, el }) {
  let scene, numbers, columns, frames, time = 0, last = null, request = null, path = null, place = null, surfaces = null, audio = null, seen = true, followed;
  const get = (i, name) => numbers[i * columns.length + columns.indexOf(name)];
  const whole = !model.get("plays"); // it stands alone: in an explorer other panels have the legend of the modes
  const follows = model.get("follows"); // it shows the instant that the explorer's other mechanism shows
  const style = `flex: 1 1 300px; min-width: 0; min-height: 150px; ${whole ? "height: 340px" : "height: 0; width: 100%"}`;
  const pictures = Array.from({ length: whole ? 2 : 1 }, (_, i) => html("canvas", { style, role: "img", ariaLabel: ["mechanism", "phase plane"][i] }));
  const play = html("button", { textContent: "play", style: "width: 4.6em" });
  const sound = html("button", { textContent: "sound", title: "hear the run, so much faster that it can be heard" });
  const scrub = html("input", { type: "range", min: 0, value: 0, style: "flex: 1 1 100px; min-width: 0; margin: 0", ariaLabel: "time" });
  const pace = html("select", { ariaLabel: "pace" });
  const state = html("span", { style: "width: 100%; font-variant-numeric: tabular-nums; line-height: 1.3" });
  const said = html("span", { role: "status" });
  const bar = (nodes) => html("div", { style: "display: flex; flex-wrap: wrap; gap: 4px 14px; align-items: center; margin: 4px" }, nodes);
  const row = html("div", { style: `display: flex; flex: 1 1 auto; min-height: 0; ${whole ? "flex-wrap: wrap" : "flex-direction: column"}` }, pictures);
  const key = bar([]), box = html("div", { className: "fl-canvas" }, [bar([...(follows ? [] : [play, scrub, pace]), sound, state]), row, key]);
  el.append(box);

  const patch = (colour) => html("span", { style: `display: inline-block; width: 1em; height: 0.7em; margin-right: 0.3em; background: ${colour}` });
  const times = (factor) => `${+factor.toPrecision(3)} times`;
  const named = (one) => (one === 1 ? "real time" : one > 1 ? `${times(one)} faster` : `${times(1 / one)} slower`);
  function load() { // new data; what the user has set stays
    if (!model.get("scene").columns) return; // nothing has been computed yet
    const before = scene, bytes = model.get("rows");
    scene = model.get("scene");
    columns = scene.columns;
    numbers = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    frames = { count: numbers.length / columns.length, get };
    scrub.max = frames.count - 1;
    go(time);
    followed = undefined;
    if (scene.speed !== before?.speed) {
      const paces = [...new Set([...PACES, scene.speed])].sort((a, b) => b - a);
      pace.replaceChildren(...paces.map((one) => html("option", { value: one, textContent: named(one), selected: one === scene.speed })));
    }
    const entries = whole ? scene.legend : scene.legend.filter(([text]) => !scene.modes.includes(text));
    key.replaceChildren(...entries.map(([text, colour]) => html("span", { style: "white-space: nowrap" }, [patch(colour), ...subscripted(text)])), said);
    box.style.cssText = `background: ${scene.paper}; color: ${scene.ink}; font-family: sans-serif; font-size: var(--jp-widgets-font-size, ${LABEL}px); padding: 4px; display: flex; flex-direction: column; height: 100%; box-sizing: border-box`;
    resize();
  }
  function go(to) { // seconds from the first frame; the other mechanism, whose frames may begin at another time, is told
    time = Math.min(Math.max(to, 0), frames.count * scene.step);
    const panels = el.closest(".fl-picture");
    if (panels && !follows) panels.instant = scene.start + time;
  }
  function follow() {
    const instant = el.closest(".fl-picture")?.instant;
    if (scene && instant !== undefined && instant !== followed) {
      followed = instant;
      go(instant - scene.start);
      if (seen) show();
    }
    request = requestAnimationFrame(follow);
  }
  let due = false;
  function soon() { // scene and rows change in one message: they are loaded once
    if (!due) queueMicrotask(() => { due = false; load(); });
    due = true;
  }
  function show() {
    if (!surfaces) return;
    const frame = Math.min(frames.count - 1, Math.floor(time / scene.step + 1e-6)), now = Object.fromEntries(columns.map((name) => [name, get(frame, name)]));
    const [[c, w, h], phase] = surfaces;
    c.clearRect(0, 0, w, h);
    now.all = numbers.subarray(frame * columns.length, (frame + 1) * columns.length);
    (scene.shapes ? shapes : mechanism)(c, w, h, scene, now);
    if (phase) showPhase(...phase, now);
    scrub.value = frame;
    const at = (scene.start + frame * scene.step).toFixed(scene.digits);
    scrub.ariaValueText = `${at} s`;
    state.textContent = `${scene.title ? `${scene.title}: ` : ""}t = ${at} s: ${scene.modes[now.mode]}; ${scene.note}`;
  }
  function showPhase(p, width, height, now) {
    p.clearRect(0, 0, width, height);
    p.drawImage(path, 0, 0, width, height);
    p.beginPath();
    p.arc(...place(now), 6, 0, 7);
    Object.assign(p, { fillStyle: scene.colours[now.mode], strokeStyle: scene.ink, lineWidth: 1.5 });
    p.fill();
    p.stroke();
  }
  function resize() {
    if (!scene || !pictures.every((canvas) => canvas.clientWidth)) return;
    scene.letters = parseFloat(getComputedStyle(box).fontSize);
    surfaces = pictures.map(fit);
    if (surfaces[1]) drawPath(...surfaces[1].slice(1));
    show();
  }
  function drawPath(width, height) {
    path = html("canvas", { width: pictures[1].width, height: pictures[1].height });
    const c = path.getContext("2d");
    c.scale(path.width / width, path.height / height);
    place = phasePlane(c, width, height, scene, frames);
  }
  function tick(now) {
    if (last !== null && frames) go((time + (now - last) / 1000 * Number(pace.value)) % (frames.count * scene.step));
    last = now;
    if (seen) show();
    request = requestAnimationFrame(tick);
  }
  function toggle() {
    if (request !== null) { cancelAnimationFrame(request); request = last = null; } else request = requestAnimationFrame(tick);
    play.textContent = request === null ? "play" : "pause";
  }
  function hear({ text, rate }, buffers) {
    sound.disabled = false;
    said.textContent = text;
    if (!buffers.length) return;
    const bytes = buffers[0], samples = new Int16Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    const made = audio.createBuffer(1, samples.length, rate), source = audio.createBufferSource();
    made.getChannelData(0).set(Float32Array.from(samples, (sample) => sample / 32767));
    source.buffer = made;
    source.connect(audio.destination);
    source.start();
  }
  play.onclick = toggle;
  sound.onclick = () => { audio ??= new AudioContext(); sound.disabled = true; said.textContent = ""; model.send({ sound: true }); };
  scrub.oninput = () => { go(Number(scrub.value) * scene.step); show(); };
  el.addEventListener("keydown", (event) => event.stopPropagation()); // a notebook takes keys for its own commands
  model.on("change:scene", soon);
  model.on("change:rows", soon);
  model.on("msg:custom", hear);
  load();
  if (follows) follow(); else if (!whole && !matchMedia("(prefers-reduced-motion: reduce)").matches) toggle();
  const observer = new ResizeObserver(resize), sight = new IntersectionObserver(([entry]) => { seen = entry.isIntersecting; });
  observer.observe(pictures[0]);
  sight.observe(el);
  return () => {
    observer.disconnect();
    sight.disconnect();
    cancelAnimationFrame(request);
    model.off("change:scene", soon);
    model.off("change:rows", soon);
    model.off("msg:custom", hear);
    audio?.close();
  };
}

export default { render };
