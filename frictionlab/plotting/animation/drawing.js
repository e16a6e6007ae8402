// How mechanisms are drawn on a canvas by the front end (frictionlab/pages), as parts.py draws them. y points up. Colours
// are those of the scene.
// Sizes as in parts.py.
const TURNS = 6, WIDTH = 0.16, MARKS = 16, HUB = 0.75, ASIDE = 0.13, ABOVE = 0.25;

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
  const [ax, ay, bx, by, r, travel] = row;
  const length = Math.hypot(bx - ax, by - ay), loop = 2 * (length + Math.PI * r), half = Math.PI / 2;
  c.save();
  c.translate(ax, ay);
  c.rotate(Math.atan2(by - ay, bx - ax));
  const outline = new Path2D();
  outline.moveTo(0, r);
  outline.arc(length, 0, r, half, -half, true);
  outline.arc(0, 0, r, -half, -3 * half, true);
  outline.closePath();
  Object.assign(c, { fillStyle: scene.pale, strokeStyle: scene.ink, lineWidth: 2 * px, lineCap: "round" });
  c.fill(outline);
  c.stroke(outline);
  c.setLineDash([0, loop / MARKS]); // dots that travel with the belt
  Object.assign(c, { lineWidth: 6 * px, lineDashOffset: -travel });
  c.stroke(outline);
  Object.assign(c, { fillStyle: scene.paper, strokeStyle: scene.grey, lineWidth: px });
  c.setLineDash([]);
  for (const x of [0, length]) { c.beginPath(); c.arc(x, 0, HUB * r, 0, 7); c.fill(); c.stroke(); }
  c.restore();
}

function springLabel(c, scene, label, [ax, ay], [bx, by], px) { // on the left, seen from its start
  const length = Math.hypot(bx - ax, by - ay) || 1, [x, y] = [(ay - by) / length, (bx - ax) / length];
  c.save();
  const away = ASIDE + (ABOVE - ASIDE) * Math.abs(y);
  c.translate((ax + bx) / 2 + away * x, (ay + by) / 2 + away * y);
  c.scale(px, -px);
  c.fillStyle = scene.ink;
  paintLabel(c, label, 0, 0, scene.letters ?? 13, x > 0.5 ? "left" : x < -0.5 ? "right" : "center");
  c.restore();
}

function shape(c, scene, { kind, colour, first, label }, row, px) {
  const numbers = row.all.subarray(first), [x, y, w, h] = numbers;
  if (kind === "wall") line(c, [[x, y], [w, h]], 4 * px, colour);
  if (kind === "spring") spring(c, [x, y], [w, h], WIDTH, px, colour);
  if (label) springLabel(c, scene, label, [x, y], [w, h], px);
  if (kind === "arrow") arrow(c, x, y, w, h, colour, px);
  if (kind === "belt") belt(c, scene, numbers, px);
  if (kind !== "block" && kind !== "disc") return;
  c.beginPath();
  kind === "disc" ? c.arc(x, y, w / 2, 0, 7) : c.rect(x - w / 2, y - h / 2, w, h);
  Object.assign(c, { fillStyle: scene.colours[row.mode], strokeStyle: scene.ink, lineWidth: 1.2 * px });
  c.fill();
  c.stroke();
}

function shapesOf(c, width, height, scene, row) { // arrows last, over the bodies
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
