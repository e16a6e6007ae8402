// What the plots need of a canvas context, written as SVG: the figure as lines and letters, to be printed.  What holds
// from a `save` to its `restore`, as a translation, is a group of SVG.
class SvgContext {
  constructor(width, height, paper) {
    this.nodes = [`<rect width="${width}" height="${height}" fill="${paper}"/>`];
    this.groups = [];
    this.path = "";
    this.dash = "";
    this.clips = 0;
    this.pen = document.createElement("canvas").getContext("2d"); // it measures letters
    this.size = `width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"`;
  }

  save() { this.groups.push(0); }
  restore() { this.nodes.push("</g>".repeat(this.groups.pop())); }
  group(attribute) { this.nodes.push(`<g ${attribute}>`); this.groups[this.groups.length - 1]++; }
  translate(x, y) { this.group(`transform="translate(${x} ${y})"`); }
  rotate(angle) { this.group(`transform="rotate(${180 * angle / Math.PI})"`); }

  clip() {
    this.nodes.push(`<clipPath id="clip${this.clips}"><path d="${this.path}"/></clipPath>`);
    this.group(`clip-path="url(#clip${this.clips++})"`);
  }

  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${x.toFixed(2)} ${y.toFixed(2)}`; }
  lineTo(x, y) { this.path += `L${x.toFixed(2)} ${y.toFixed(2)}`; }
  closePath() { this.path += "Z"; }
  rect(x, y, w, h) { this.path += `M${x} ${y}h${w}v${h}h${-w}Z`; }
  arc(x, y, r) { this.path += `M${x + r} ${y}a${r} ${r} 0 1 0 ${-2 * r} 0a${r} ${r} 0 1 0 ${2 * r} 0`; } // a circle
  setLineDash(dash) { this.dash = dash.join(" "); }

  stroke() {
    this.nodes.push(`<path d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}"`
      + ` stroke-linejoin="round" stroke-dasharray="${this.dash || "none"}"/>`);
  }

  fill() { this.nodes.push(`<path d="${this.path}" fill="${this.fillStyle}"/>`); }

  measureText(text) { // in the font that all systems have
    this.pen.font = this.font.replace("system-ui, ", "");
    return this.pen.measureText(text);
  }

  fillText(text, x, y) {
    const [, style, size] = this.font.match(/^(italic)? ?([\d.]+)px/),
      escaped = text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
    const anchor = { center: "middle", right: "end" }[this.textAlign] ?? "start";
    this.nodes.push(`<text xml:space="preserve" x="${x}" y="${y + 0.35 * Number(size)}" font-size="${size}"`
      + ` text-anchor="${anchor}" font-family="sans-serif" font-style="${style ?? "normal"}"`
      + ` fill="${this.fillStyle}">${escaped}</text>`);
  }

  text() { return `<svg xmlns="http://www.w3.org/2000/svg" ${this.size}>${this.nodes.join("\n")}</svg>\n`; }
}
