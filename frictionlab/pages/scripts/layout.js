// Where the parts of a mechanism are: sizes from the samples of a window, places from one sample. The rules are
// those of frictionlab.plotting.animation: tilting_belt.py and parts.py.
const REACH = 0.5, LONGEST_ARROW = 0.6, MARGIN = 0.25; // of pictures that are not drawn in metres
const COLOURS = { orange: "#E69F00", sky: "#56B4E9", green: "#009E73", blue: "#0072B2", vermillion: "#D55E00",
  purple: "#CC79A7", grey: "#999999" };

// biome-ignore lint/complexity/useMathMinMax: NaN is passed over
const largerSize = (a, b) => (Math.abs(b) > a ? Math.abs(b) : a);
const largest = (arrays) => arrays.reduce((m, array) => array.reduce(largerSize, m), 0);

function roundDown125(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].map((d) => d * power).find((v) => v <= x * (1 + 1e-9)) ?? power;
}

// The picture of a result as {scene, draw, row(samples, i), note}, or null; `about` is the mechanism as data.
function pictureOf(about, result, look) {
  if (!about) return null;
  return (about.kind === "TiltingBelt" ? tiltingBelt : partsPicture)(about, result, look);
}

function colouredScene({ structure }, look) {
  const { ink, paper, grey, pale, letters } = look, colours = structure.colours;
  return { ink, paper, grey, pale, letters, colours,
    force_colours: [legible("#0072B2", look), COLOURS.vermillion, ink] };
}

function tiltingBelt(about, result, look) {
  const { samples, structure, parameters: p } = result;
  const get = (data, name, i) => data.byName[name]?.[i] ?? 0;
  const size = Math.max(p.l1, p.l2) || 0.2, wheels = [Math.max(p.l1, 0.25 * size), Math.max(p.l2, 0.25 * size)];
  const room = 0.4 * Math.min(...wheels), top = largest(["x1", "y1", "x2", "y2"].map(samples.column));
  const s = result.magnify ?? (top > 0 ? roundDown125(room / top) : 1), reach = Math.max(room, s * top);
  const spring = Math.max(0.6 * size,
    1.3 * s * samples.column("penetration").reduce((a, b) => Math.max(a, b), -Infinity));
  const radius = 0.2 * size, block = [0.4 * size, 0.3 * size];
  const walls = [-size - reach, wheels[1] + 0.7 * size + reach, -radius - 0.8 * size - reach], out = 0.6 * size + reach;
  const anchor = [-block[0] / 2 - out, spring + block[1] + out], margin = 0.15 * size;
  const limits = [[Math.min(walls[0], anchor[0], -wheels[0] - radius - reach) - margin, walls[1] + margin],
    [walls[2] - margin, anchor[1] + 2 * margin]];
  const force = Math.max(largest([samples.column("normal_force"), samples.column("friction_force")]), Math.abs(p.F));
  const scale = force / (0.6 * size) || 1;
  const scene = { ...colouredScene(result, look), size, wheels, radius, block, spring, walls, anchor, limits, reach,
    scale, preload: p.F, names: about.names };
  return {
    scene, draw: mechanism, note: `displacements × ${s}, tilt as it is`,
    bodies(data, i) { // the slider, the middle of the belt, and both of its ends, which tilt it
      const { slider_x: x, slider_y: y, belt_x, belt_y, slope } = this.row(data, i), [w, h] = block;
      const end = (side) => ({ box: [belt_x + side, belt_y + side * slope - radius, 2 * radius, 2 * radius],
        along: { phi: (_, dy) => -dy / side } });
      const all = [
        { box: [x, y + h / 2, w, h], along: { x1: (dx) => dx / s, y1: (_, dy) => dy / s } },
        { box: [belt_x, belt_y - radius, Math.min(...wheels), 2 * radius],
          along: { x2: (dx) => dx / s, y2: (_, dy) => dy / s } },
        end(-wheels[0]), end(wheels[1]),
      ];
      return all.filter(({ along }) => Object.keys(along).every((name) => structure.states.includes(name)));
    },
    row(data, i) {
      const [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map((name) => s * get(data, name, i)),
        phi = get(data, "phi", i), mode = data.modes[i];
      const foot = structure.modes[mode] === "separation" ? y1 : y2 - (x1 - x2) * phi;
      return {
        slider_x: x1, slider_y: y1 + spring, foot_x: x1, foot_y: foot, belt_x: x2, belt_y: y2, slope: -phi,
        travel: s * p.v * data.times[i], normal_force: get(data, "normal_force", i),
          friction_force: get(data, "friction_force", i), mode,
      };
    },
  };
}

function partsPicture(about, result, look) {
  const { samples, structure, parameters: p } = result, { parts, width, marks } = about, names = new Set();
  for (const part of parts) for (const place of Object.values(part)) for (const name of [place?.right,
    place?.up]) if (name) names.add(name.replace("-", ""));
  const value = (data, name, i) => data.byName[name]?.[i] ?? p[name] ?? 0;
  const top = Math.max(...[...names].map((name) => samples.byName[name] ? largest([samples.byName[name]])
    : Math.abs(p[name] ?? 0)), 0);
  const s = result.magnify ?? (top > 0 ? roundDown125(REACH / top) : 1);
  const at = (place, data, i) => {
    const { turn } = place, [x, y] = [[place.x, place.right], [place.y, place.up]].map(([base, name]) =>
      base + (name ? (name.startsWith("-") ? -s : s) * value(data, name.replace("-", ""), i) : 0));
    if (!turn) return [x, y];
    const angle = value(data, turn.angle, i) + turn.start;
    return [x + turn.right * Math.cos(angle), y + turn.up * Math.sin(angle)];
  };
  const contacts = parts.filter(({ part }) => part === "Forces").map(({ contact }) => contact);
  const forces = contacts.flatMap((contact) =>
    ["normal_force", "friction_force"].map((name) => samples.byName[name + contact] ?? new Float64Array(1)));
  const arrow = LONGEST_ARROW / (largest(forces) || Infinity);
  const base = colouredScene(result, look), shapes = [];
  const places = { // the numbers of each part's shapes in a frame
    Wall: (part, d, i) => [[...at(part.start, d, i), ...at(part.end, d, i)]],
    Spring: (part, d, i) => {
      const end = at(part.end, d, i), loose = part.loose && structure.modes[d.modes[i]] === part.loose;
      const start = loose ? [end[0] + part.start.x - part.end.x, end[1] + part.start.y - part.end.y]
        : at(part.start, d, i);
      return [[...start, ...end]];
    },
    Block: (part, d, i) => [[...at(part.at, d, i), part.width, part.height]],
    Belt: (part, d, i) => [[part.start, part.end, part.y, part.speed ? s * value(d, part.speed, i) * d.times[i] : 0]],
    Forces: (part, d, i) => {
      const foot = at(part.at, d, i);
      return [[...foot, 0, arrow * value(d, `normal_force${part.contact}`, i)],
        [...foot, arrow * value(d, `friction_force${part.contact}`, i), 0]];
    },
  };
  for (const part of parts) {
    const kinds = { Wall: ["wall"], Spring: ["spring"], Block: [part.disc ? "disc" : "block"], Belt: ["belt"],
      Forces: ["arrow", "arrow"] }[part.part];
    kinds.forEach((kind, k) => shapes.push({ kind, first: 4 * shapes.length,
      colour: { wall: base.grey, belt: base.grey, spring: base.ink, arrow: base.force_colours[k] }[kind] }));
  }
  const numbers = (data, i) => Float64Array.from(parts.flatMap((part) => places[part.part](part, data, i)).flat());
  const [xs, ys] = [[Infinity, -Infinity], [Infinity, -Infinity]];
  const cover = (x, y) => { xs[0] = Math.min(xs[0], x); xs[1] = Math.max(xs[1], x); ys[0] = Math.min(ys[0], y);
    ys[1] = Math.max(ys[1], y); };
  for (let i = 0; i < samples.times.length; i += 4) {
    const all = numbers(samples, i);
    for (const { kind, first } of shapes) {
      const [x, y, w, h] = all.subarray(first, first + 4);
      if (kind === "wall" || kind === "spring") { cover(x, y); cover(w, h); }
      if (kind === "block" || kind === "disc") { cover(x - w / 2, y - h / 2); cover(x + w / 2, y + h / 2); }
      if (kind === "belt") { cover(x, w); cover(y, w); }
      if (kind === "arrow") { cover(x, y); cover(x + w, y + h); }
    }
  }
  const limits = [xs, ys].map(([low, high]) => [low - MARGIN, high + MARGIN]);
  return {
    scene: { ...base, shapes, limits, width, marks }, draw: (c, w, h, scene, row) => shapesOf(c, w, h, scene, row),
      note: names.size ? `displacements × ${s}` : "angles as they are",
    bodies: (data, i) => parts.filter(({ part }) => part === "Block").map(({ at: place, width: w, height: h }) =>
      ({ box: [...at(place, data, i), w, h],
        along: movesOf(place, s, structure.states, value(data, place.turn?.angle, i)) }))
      .filter(({ along }) => Object.keys(along).length),
    row: (data, i) => ({ all: numbers(data, i), mode: data.modes[i] }),
  };
}

// what a step of (dx, dy) of a body does to each coordinate that moves it; `angle` is that by which it is turned
function movesOf({ right, up, turn }, s, states, angle) {
  const moves = {}, bare = (name) => name.replace("-", ""), sign = (name) => (name[0] === "-" ? -s : s);
  if (turn?.right && turn.up && states.includes(turn.angle)) { // which alone follows a step in both directions
    const a = angle + turn.start;
    return { [turn.angle]: (dx, dy) =>
      withinTurn(Math.atan2(Math.sin(a) + dy / turn.up, Math.cos(a) + dx / turn.right) - a) };
  }
  if (states.includes(bare(right))) moves[bare(right)] = (dx) => dx / sign(right);
  if (states.includes(bare(up))) moves[bare(up)] = (_, dy) => dy / sign(up);
  return moves;
}

const shapesOf = shapes;
