// What the plots need of a canvas context, written as SVG: the figure as lines and letters, to be printed.
class SvgContext {
  constructor(width, height, paper) {
    this.nodes = [];
    this.matrix = [1, 0, 0, 1, 0, 0];
    this.stack = [];
    this.path = "";
    this.dash = [];
    this.clips = 0;
    this.clipped = "";
    this.pen = document.createElement("canvas").getContext("2d"); // it measures letters
    const size = `width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"`;
    this.head = `<svg xmlns="http://www.w3.org/2000/svg" ${size}>`
      + `<rect width="${width}" height="${height}" fill="${paper}"/>`;
  }

  save() { this.stack.push({ matrix: [...this.matrix], clipped: this.clipped, dash: this.dash }); }
  restore() { Object.assign(this, this.stack.pop()); }
  setLineDash(dash) { this.dash = dash; }

  transform(a, b, c, d, e, f) {
    const [m, n, o, p, q, r] = this.matrix;
    this.matrix = [m * a + o * b, n * a + p * b, m * c + o * d, n * c + p * d, m * e + o * f + q, n * e + p * f + r];
  }

  translate(x, y) { this.transform(1, 0, 0, 1, x, y); }
  rotate(angle) { this.transform(Math.cos(angle), Math.sin(angle), -Math.sin(angle), Math.cos(angle), 0, 0); }
  scale(x, y) { this.transform(x, 0, 0, y, 0, 0); }

  at(x, y) {
    const [a, b, c, d, e, f] = this.matrix;
    return `${(a * x + c * y + e).toFixed(2)} ${(b * x + d * y + f).toFixed(2)}`;
  }

  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${this.at(x, y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${this.at(x, y)}`; }
  closePath() { this.path += "Z"; }
  rect(x, y, w, h) { this.path += `M${this.at(x, y)}L${this.at(x + w, y)}L${this.at(x + w, y + h)}L${this.at(x,
    y + h)}Z`; }
  // a circle
  arc(x, y, r) { this.path += `M${this.at(x + r, y)}A${r} ${r} 0 1 0 ${this.at(x - r,
    y)}A${r} ${r} 0 1 0 ${this.at(x + r, y)}`; }

  clip() {
    this.clipped = `clip${this.clips++}`;
    this.nodes.push(`<clipPath id="${this.clipped}"><path d="${this.path}"/></clipPath>`);
  }

  shape(looks) {
    const clip = this.clipped ? ` clip-path="url(#${this.clipped})"` : "";
    this.nodes.push(`<path d="${this.path}" ${looks}${clip}/>`);
  }

  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    const pen = `stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"`;
    this.shape(`fill="none" ${pen}${dash}`);
  }

  fill() { this.shape(`fill="${this.fillStyle}"`); }

  measureText(text) { // in the font that all systems have
    this.pen.font = this.font.replace("system-ui, ", "");
    return this.pen.measureText(text);
  }

  fillText(text, x, y) {
    const [, style, size] = this.font.match(/^(italic )?([\d.]+)px/),
      escaped = text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
    const baseline = Number(y) + 0.35 * Number(size);
    const [a, b, c, d, e, f] = this.matrix, anchor = { center: "middle", right: "end" }[this.textAlign] ?? "start";
    this.nodes.push(`<text xml:space="preserve" transform="matrix(${a} ${b} ${c} ${d} ${e} ${f})" x="${x}"`
      + ` y="${baseline}" font-size="${size}" text-anchor="${anchor}"`
      + ` font-family="sans-serif"${style ? ' font-style="italic"' : ""} fill="${this.fillStyle}">${escaped}</text>`);
  }

  text() { return `${this.head}${this.nodes.join("\n")}</svg>\n`; }
}
