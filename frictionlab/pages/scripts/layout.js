// Where the parts of a mechanism are: sizes from the samples of a window, places from one sample. The rules are
// those of frictionlab/plotting/animation/parts.py.
const REACH = 0.5, LONGEST_ARROW = 0.6, MARGIN = 0.25, FOOT = 0.1; // of pictures that are not drawn in metres
const COLOURS = { orange: "#E69F00", sky: "#56B4E9", green: "#009E73", blue: "#0072B2", vermillion: "#D55E00",
  purple: "#CC79A7", grey: "#999999" };

// biome-ignore lint/complexity/useMathMinMax: NaN is passed over
const largerSize = (a, b) => (Math.abs(b) > a ? Math.abs(b) : a);
const largest = (arrays) => arrays.reduce((m, array) => array.reduce(largerSize, m), 0);

function roundDown125(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].map((d) => d * power).find((v) => v <= x * (1 + 1e-9)) ?? power;
}

// The picture of a result as {scene, draw, row(samples, i), note, bodies}, or null
function pictureOf(result, look) {
  const { samples, structure, parameters: p, mechanism: parts } = result;
  if (!parts) return null;
  const points = parts.flatMap((part) => Object.values(part)).filter((value) => value?.x !== undefined);
  const names = new Set(points.flatMap(({ right, up }) => [right, up]).filter(Boolean).map(bare));
  const value = (data, name, i) => data.byName[name]?.[i] ?? p[name] ?? 0;
  const top = Math.max(...[...names].map((name) => samples.byName[name] ? largest([samples.byName[name]])
    : Math.abs(p[name] ?? 0)), 0);
  const s = result.magnify ?? (top > 0 ? roundDown125(REACH / top) : 1);
  const signed = (name, data, i) => (name ? sign(name) * value(data, bare(name), i) : 0);
  const angleOf = (turn, data, i) => drawnAngle(turn, signed(turn.angle, data, i));
  const at = ({ x, y, right, up, turn, on }, data, i) => {
    const there = [x + s * signed(right, data, i), y + s * signed(up, data, i)];
    if (on) return [there[0], surface(on, there[0], data, i)];
    if (!turn) return there;
    const angle = angleOf(turn, data, i);
    return [there[0] + turn.right * Math.cos(angle), there[1] + turn.up * Math.sin(angle)];
  };
  const surface = ({ start, end, radius }, x, data, i) => { // of a belt, or its prolongation
    const [[ax, ay], [bx, by]] = [start, end].map((point) => at(point, data, i)), slope = (by - ay) / (bx - ax);
    return ay + slope * (x - ax) + radius * Math.hypot(1, slope);
  };
  const contacts = parts.filter(({ part }) => part === "Forces").map(({ contact = "" }) => contact);
  const forces = contacts.flatMap((contact) =>
    ["normal_force", "friction_force"].map((name) => samples.byName[name + contact] ?? new Float64Array(1)));
  const loads = parts.filter(({ part }) => part === "Load").map(({ force }) => p[force] ?? 0);
  const arrow = LONGEST_ARROW / (largest([...forces, loads]) || Infinity);
  const { ink, paper, grey, pale, letters } = look, shapes = [];
  const colours = structure.colours.map((colour) => legible(colour, look));
  const base = { ink, paper, grey, pale, letters, colours };
  const forceColours = [legible("#0072B2", look), COLOURS.vermillion];
  const places = { // the numbers of each part's shapes in a frame
    Wall: (part, d, i) => [[...at(part.start, d, i), ...at(part.end, d, i)]],
    Spring: (part, d, i) => {
      const end = at(part.end, d, i), loose = part.loose && structure.modes[d.modes[i]] === part.loose;
      const start = loose ? [end[0] + part.start.x - part.end.x, end[1] + part.start.y - part.end.y]
        : at(part.start, d, i);
      return part.loose ? [[...start, ...end], footOf(start, end)] : [[...start, ...end]];
    },
    Block: (part, d, i) => [[...at(part.at, d, i), part.width, part.height]],
    Belt: (part, d, i) => [[...at(part.start, d, i), ...at(part.end, d, i), part.radius,
      s * signed(part.speed, d, i) * d.times[i]]],
    Forces: (part, d, i) => {
      const foot = at(part.at, d, i);
      return [[...foot, 0, arrow * value(d, `normal_force${part.contact ?? ""}`, i)],
        [...foot, arrow * value(d, `friction_force${part.contact ?? ""}`, i), 0]];
    },
    Load: (part, d, i) => {
      const [x, y] = at(part.at, d, i), length = arrow * value(d, part.force, i);
      return [[x, y + length, 0, -length]];
    },
  };
  let count = 0;
  for (const part of parts) {
    const kinds = { Wall: ["wall"], Spring: part.loose ? ["spring", "wall"] : ["spring"], Belt: ["belt"],
      Block: [part.disc ? "disc" : "block"], Forces: ["arrow", "arrow"], Load: ["arrow"] }[part.part];
    kinds.forEach((kind, k) => {
      const colour = part.part === "Wall" ? grey : part.part === "Forces" ? forceColours[k] : ink;
      shapes.push({ kind, first: count, colour, label: kind === "spring" ? part.label : "" });
      count += kind === "belt" ? 6 : 4;
    });
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
      if (kind === "belt") for (const [px, py] of [[x, y], [w, h]]) {
        cover(px - all[first + 4], py - all[first + 4]);
        cover(px + all[first + 4], py + all[first + 4]);
      }
      if (kind === "arrow") { cover(x, y); cover(x + w, y + h); }
    }
  }
  const limits = [xs, ys].map(([low, high]) => [low - MARGIN, high + MARGIN]);
  const bodies = ["Block", "Belt"].flatMap((kind) => parts.filter(({ part }) => part === kind)).flatMap(bodiesOf);
  return {
    scene: { ...base, shapes, limits }, draw: shapesOf,
    note: [names.size ? `displacements × ${s}` : "",
      !names.size || points.some(({ turn }) => turn) ? "angles × 1" : ""].filter(Boolean).join(", "),
    bodies: /** @returns {any[]} */ (data, i) => bodies.map(({ place, shift: [dx, dy], width: w, height: h }) => {
      const [x, y] = at(place, data, i), angle = place.turn ? angleOf(place.turn, data, i) : 0;
      return { box: [x + dx, y + dy, w, h], along: movesOf(place, s, structure.states, angle) };
    }).filter(({ along }) => Object.keys(along).length),
    row: (data, i) => ({ all: numbers(data, i), mode: data.modes[i] }),
  };
}

function footOf([ax, ay], [bx, by]) { // both ends of the plate across the start of a contact spring
  const share = FOOT / (Math.hypot(bx - ax, by - ay) || 1), [x, y] = [(ay - by) * share, (bx - ax) * share];
  return [ax - x, ay - y, ax + x, ay + y];
}

// what can be dragged of a part: a block; of a belt its middle, and both wheels
function bodiesOf({ part, at, width, height, start, end, radius }) {
  const none = [0, 0];
  if (part === "Block") return [{ place: at, shift: none, width, height }];
  if (part !== "Belt") return [];
  const middle = { ...start, turn: null, on: null }, wheel = { shift: none, width: 2 * radius, height: 2 * radius };
  return [{ place: middle, shift: [0, start.turn ? -radius : 0], width: 4 * radius, height: 2 * radius },
    ...[start, end].filter(({ turn }) => turn).map((place) => ({ ...wheel, place }))];
}

const bare = (name = "") => name.replace("-", "");
const sign = (name = "") => (name.startsWith("-") ? -1 : 1);
const drawnAngle = ({ linear, start }, angle) => (linear ? Math.atan(angle) : angle) + start;

// what a step of (dx, dy) of a body does to each coordinate that moves it; `angle` is that at which it is drawn
function movesOf({ right, up, turn }, s, states, angle) {
  const moves = {};
  if (turn?.right && turn.up && states.includes(bare(turn.angle))) { // which alone follows a step in both directions
    const to = (dx, dy) => Math.atan2(Math.sin(angle) + dy / turn.up, Math.cos(angle) + dx / turn.right);
    const slope = (a) => Math.tan(a - turn.start);
    const change = (a) => (turn.linear ? slope(a) - slope(angle) : withinTurn(a - angle));
    return { [bare(turn.angle)]: (dx, dy) => sign(turn.angle) * change(to(dx, dy)) };
  }
  if (states.includes(bare(right))) moves[bare(right)] = (dx) => dx / (sign(right) * s);
  if (states.includes(bare(up))) moves[bare(up)] = (_, dy) => dy / (sign(up) * s);
  return moves;
}
