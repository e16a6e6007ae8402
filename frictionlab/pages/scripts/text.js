// Labels: LaTeX such as "$\dot{x}_{1}$ (m/s)" as parts, which are set in the page or painted on a canvas.
const SYMBOLS = {
  alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", varepsilon: "ε", zeta: "ζ", eta: "η", theta: "θ",
  vartheta: "ϑ", kappa: "κ", lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", rho: "ρ", sigma: "σ", tau: "τ", phi: "φ",
  varphi: "φ", psi: "ψ", omega: "ω", Delta: "Δ", Phi: "Φ", Psi: "Ψ", Omega: "Ω", infty: "∞", cdot: "·", times: "×",
  circ: "°", prime: "′", ast: "*", star: "*",
};
const OVER = { dot: "\u0307", ddot: "\u0308", bar: "\u0304", tilde: "\u0303", hat: "\u0302" };
const BARE_LETTER = /\\(d?dot|bar|tilde|hat)\s*(\\[A-Za-z]+|[A-Za-z])/g; // below a mark, without braces
const SMALL = 0.72; // size of an index, relative to its letter

// Parts of a label: {text, italic, shift}, where shift is -1 for an index and 1 for an exponent.
function labelParts(label) {
  return label.split(/(?<!\\)\$/).flatMap((piece, i) => (i % 2 ? mathParts(piece) : plainPart(piece)));
}

function plainPart(text) {
  const shown = text.replaceAll("\\$", "$");
  return shown ? [{ text: shown, italic: false, shift: 0 }] : [];
}

function mathParts(math) {
  const pattern = /([_^])?(?:\{((?:[^{}]|\{[^{}]*\})*)\}|\\(\w+?)(?:\{([^{}]*)\}|(?![A-Za-z]))|\\.|([^\\_^{}]))\s?/g;
  const parts = [];
  for (const [, place, group, command, argument, letter] of math.replace(BARE_LETTER, "\\$1{$2}").matchAll(pattern)) {
    const shift = { _: -1, "^": 1 }[place] ?? 0, upright = command === "mathrm" || command === "text";
    let inner;
    if (group !== undefined) inner = mathParts(group);
    else if (command && OVER[command]) inner = mathParts(argument
      ?? "").map((p, i) => (i ? p : { ...p, text: p.text + OVER[command] }));
    else if (upright) inner = [{ text: (argument ?? "").replaceAll("\\ ", " "), italic: false, shift: 0 }];
    else if (command) inner = [{ text: SYMBOLS[command] ?? command, italic: /^[a-z]/.test(command), shift: 0 },
      ...(argument ? mathParts(argument) : [])];
    else if (letter) inner = [{ text: letter.replace("'", "′").replace("-", "−"), italic: /[A-Za-z]/.test(letter),
      shift: 0 }];
    else continue;
    parts.push(...inner.map((part) => ({ ...part, shift: shift || part.shift })));
  }
  return parts;
}

const plainLabel = (label) => labelParts(label).map(({ text }) => text).join("");

function labelNodes(label) { // for the page
  return labelParts(label).map(({ text, italic, shift }) => {
    const node = html(shift < 0 ? "sub" : shift > 0 ? "sup" : italic ? "i" : "span", { textContent: text });
    if (shift && italic) node.style.fontStyle = "italic";
    return node;
  });
}

const partFont = ({ italic, shift }, size) =>
  `${italic ? "italic " : ""}${shift ? SMALL * size : size}px system-ui, sans-serif`;

function labelWidth(c, label, size) {
  return labelParts(label).reduce((sum, part) =>
    { c.font = partFont(part, size); return sum + c.measureText(part.text).width; }, 0);
}

function paintLabel(c, label, x, y, size, align = "left") { // y is the middle of the letters
  let at = x - { left: 0, center: 0.5, right: 1 }[align] * labelWidth(c, label, size);
  Object.assign(c, { textAlign: "left", textBaseline: "middle" });
  for (const part of labelParts(label)) {
    c.font = partFont(part, size);
    c.fillText(part.text, at, y - 0.35 * size * part.shift);
    at += c.measureText(part.text).width;
  }
}

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const raised = (number) => String(number).replace(/[-0-9]/g, (digit) => RAISED[digit]);
const shownUnit = (unit) => unit.replace(/\^(-?\d+)/g, (_, power) => raised(power));

function shortNumber(v, digits = 5) { // as Python writes it with the format "g"
  if (!Number.isFinite(v)) return String(v);
  const rounded = Number(v.toPrecision(digits)), size = Math.abs(rounded);
  return size && (size < 1e-4 || size >= 10 ** Math.max(digits, 5)) ? rounded.toExponential().replace("e+", "e")
    : String(rounded);
}
