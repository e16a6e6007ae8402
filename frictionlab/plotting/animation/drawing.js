// How mechanisms are drawn on a canvas by the front end (frictionlab/pages). The slider on the tilting belt, with
// lengths in metres, is drawn as draw_mechanism in tilting_belt.py draws it; a scene that has scene.shapes as
// parts.py draws it. y points up. Colours are those of the scene.
const TURNS = 6, MARKS = 16;

function html(tag, properties = {}, children = []) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

function line(c, points, width, colour) {
  c.beginPath();
  for (const [x, y] of points) c.lineTo(x, y);
  Object.assign(c, { lineWidth: width, strokeStyle: colour, lineJoin: "round" });
  c.stroke();
}

function spring(c, [ax, ay], [bx, by], width, px, colour) {
  const [dx, dy] = [bx - ax, by - ay], length = Math.hypot(dx, dy) || 1;
  const at = (along, across) => [ax + along * dx - across * dy / length, ay + along * dy + across * dx / length];
  const turns = Array.from({ length: 2 * TURNS },
    (_, i) => at(0.2 + 0.6 * (i + 1) / (2 * TURNS + 1), (i % 2 ? -width : width) / 2));
  line(c, [at(0, 0), at(0.2, 0), ...turns, at(0.8, 0), at(1, 0)], px, colour);
}

function arrow(c, x, y, dx, dy, colour, px) {
  const length = Math.hypot(dx, dy);
  if (!length) return;
  const head = Math.min(13 * px, length), [ux, uy] = [dx / length, dy / length], [ex, ey] = [x + dx, y + dy];
  line(c, [[x, y], [ex - head * ux, ey - head * uy]], 4 * px, colour);
  c.beginPath();
  c.moveTo(ex, ey);
  for (const side of [1, -1]) c.lineTo(ex - head * ux - side * head * uy / 2, ey - head * uy + side * head * ux / 2);
  c.fillStyle = colour;
  c.fill();
}

function belt(c, scene, row, px) {
  const [left, right] = scene.wheels, r = scene.radius, loop = 2 * (left + right + Math.PI * r), half = Math.PI / 2;
  c.save();
  c.translate(row.belt_x, row.belt_y);
  c.rotate(Math.atan(row.slope));
  const outline = new Path2D();
  outline.moveTo(-left, 0);
  outline.arc(right, -r, r, half, -half, true);
  outline.arc(-left, -r, r, -half, -3 * half, true);
  outline.closePath();
  Object.assign(c, { fillStyle: scene.pale, strokeStyle: scene.ink, lineWidth: 2 * px, lineCap: "round" });
  c.fill(outline);
  c.stroke(outline);
  c.setLineDash([0, loop / MARKS]); // dots that travel with the belt
  Object.assign(c, { lineWidth: 6 * px, lineDashOffset: -row.travel });
  c.stroke(outline);
  Object.assign(c, { fillStyle: scene.paper, strokeStyle: scene.grey, lineWidth: px });
  c.setLineDash([]);
  for (const x of [-left, right]) { c.beginPath(); c.arc(x, -r, 0.75 * r, 0, 7); c.fill(); c.stroke(); }
  c.restore();
  const n = Math.hypot(1, row.slope); // the wheels' centres, seen from outside
  return [-left, right].map((x) => [row.belt_x + (x + r * row.slope) / n, row.belt_y + (x * row.slope - r) / n]);
}

function mechanism(c, width, height, scene, row) {
  const [[x0, x1], [y0, y1]] = scene.limits, k = Math.min(width / (x1 - x0), height / (y1 - y0)), px = 1 / k;
  const [w, h] = scene.block, [left, right, ground] = scene.walls, [ax, ay] = scene.anchor, size = scene.size;
  const x = row.slider_x, y = row.slider_y, middle = y + h / 2, span = scene.reach + 0.25 * size, e = 0.12 * size;
  c.save();
  c.translate((width - k * (x1 - x0)) / 2 - k * x0, (height + k * (y1 - y0)) / 2 + k * y0);
  c.scale(k, -k);
  const rest = scene.spring + h / 2, r = scene.radius;
  line(c, [[left, rest - span], [left, Math.min(rest + span, ay - 2 * e)]], 4 * px, scene.grey);
  line(c, [[right, -r - span], [right, span - r]], 4 * px, scene.grey);
  line(c, [[0.9 * x0, ground], [scene.wheels[1] + scene.reach + r, ground]], 4 * px, scene.grey);
  line(c, [[ax - e, ay - e], [ax + e, ay + e]], 4 * px, scene.grey);
  const [first, second] = belt(c, scene, row, px);
  const springs = /** @type {Record<string, any>} */ ({ k1: [[left, middle], [x - w / 2, middle]], k2: [[row.foot_x, row.foot_y], [x, y]],
    k3: [[ax, ay], [x - w / 2, y + h]], k4: [second, [right, second[1]]],
    k5: [[first[0], ground], first], k6: [[second[0], ground], second] });
  for (const [from, to] of Object.values(springs)) spring(c, from, to, e, px, scene.ink);
  line(c, [[row.foot_x - 5 * px, row.foot_y], [row.foot_x + 5 * px, row.foot_y]], 3 * px, scene.ink);
  c.fillStyle = scene.colours[row.mode];
  c.fillRect(x - w / 2, y, w, h);
  line(c, [[x - w / 2, y], [x + w / 2, y], [x + w / 2, y + h], [x - w / 2, y + h], [x - w / 2, y]], 1.2 * px,
    scene.ink);
  const [normal, friction, preload] = scene.force_colours, top = y + h + scene.preload / scene.scale;
  arrow(c, x + 0.35 * w, top, 0, -scene.preload / scene.scale, preload, px);
  arrow(c, x, middle, 0, row.normal_force / scene.scale, normal, px);
  arrow(c, x, middle, row.friction_force / scene.scale, 0, friction, px);
  Object.assign(c, { fillStyle: scene.ink, font: `italic ${scene.letters ?? 13}px serif`, textAlign: "center",
    textBaseline: "middle" });
  for (const [name, [from, to]] of Object.entries(springs).filter(([name]) => scene.names[name])) {
    const [dx, dy] = scene.names[name];
    c.save();
    c.translate((from[0] + to[0]) / 2 + dx * size, (from[1] + to[1]) / 2 + dy * size);
    c.scale(px, -px);
    c.fillText(name === "k2" ? "k₂, kₙₗ" : "k" + "₁₂₃₄₅₆"[Number(name[1]) - 1], 0, 0);
    c.restore();
  }
  c.restore();
}

function shape(c, scene, { kind, colour, first }, row, px) {
  const v = row.all.subarray(first), [x, y, w, h] = v;
  if (kind === "wall") line(c, [[x, y], [w, h]], 4 * px, colour);
  if (kind === "spring") spring(c, [x, y], [w, h], scene.width, px, colour);
  if (kind === "arrow") arrow(c, x, y, w, h, colour, px);
  if (kind === "belt") { // from x to y at the height w; its surface has travelled by h
    line(c, [[x, w], [y, w]], 3 * px, colour);
    for (let i = 0; i < scene.marks; i++) {
      const way = (h + (y - x) * i / scene.marks) % (y - x), at = x + (way < 0 ? way + y - x : way);
      line(c, [[at - 2 * px, w], [at + 2 * px, w]], 4 * px, scene.ink);
    }
  }
  if (kind !== "block" && kind !== "disc") return;
  c.beginPath();
  kind === "disc" ? c.arc(x, y, w / 2, 0, 7) : c.rect(x - w / 2, y - h / 2, w, h);
  Object.assign(c, { fillStyle: scene.colours[row.mode], strokeStyle: scene.ink, lineWidth: 1.2 * px });
  c.fill();
  c.stroke();
}

function shapes(c, width, height, scene, row) { // arrows last, over the bodies
  const [[x0, x1], [y0, y1]] = scene.limits, k = Math.min(width / (x1 - x0), height / (y1 - y0));
  c.save();
  c.translate((width - k * (x1 - x0)) / 2 - k * x0, (height + k * (y1 - y0)) / 2 + k * y0);
  c.scale(k, -k);
  const arrows = scene.shapes.filter(({ kind }) => kind === "arrow"),
    others = scene.shapes.filter(({ kind }) => kind !== "arrow");
  for (const one of [...others, ...arrows]) shape(c, scene, one, row, 1 / k);
  c.restore();
}

// empties it; one unit is a CSS pixel, sharp on dense screens; at the same size it is wiped, which is quicker
function fit(canvas) {
  const dense = window.devicePixelRatio || 1, { clientWidth: width, clientHeight: height } = canvas,
    context = canvas.getContext("2d");
  const size = { width: Math.round(width * dense), height: Math.round(height * dense) };
  if (context.reset && canvas.width === size.width && canvas.height === size.height) context.reset();
    else Object.assign(canvas, size);
  context.scale(dense, dense);
  return [context, width, height];
}
