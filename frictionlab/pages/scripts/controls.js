// Controls of one value each, made from their data: numbers, switches, choices, texts, ranges.
//
// A control is {name, node, show(value), positions}; it calls `changed(name, value, dragging)` when it is moved, and
// never because it is shown.
const MOST_STEPS = 300; // of a slider from one end to the other
const STEPS_PER_DECADE = 50;
let numberControls = 0; // made so far: their identifiers in the page
const roundNumber = (v, digits = 9) => Number(v.toPrecision(digits));

// both ends, round numbers between them, and the value itself to the last bit
function sliderPositions(low, high, value, log) {
  const inner = log ? logarithmicPositions(low, high) : linearPositions(low, high);
  const apart = inner.filter((v) => low < v && v < high && Math.abs(v - value) > 1e-11 * Math.abs(value));
  return [...new Set([low, ...apart, value, high])].sort((a, b) => a - b);
}

function linearPositions(low, high) {
  const step = sliderStep(low, high), first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => roundNumber((first + i) * step));
}

function sliderStep(low, high) { // 1, 2 or 5 times a power of ten
  const least = (high - low) / MOST_STEPS || 0.1, power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find((s) => s * power >= least * (1 - 1e-9)) * power;
}

function logarithmicPositions(low, high) { // powers of ten among them
  const first = Math.ceil(Math.log10(low) * STEPS_PER_DECADE), last = Math.floor(Math.log10(high) * STEPS_PER_DECADE);
  return Array.from({ length: last - first + 1 }, (_, i) => roundNumber(10 ** ((first + i) / STEPS_PER_DECADE), 3));
}

function nearest(positions, value) {
  return positions.reduce((best, v, i) => (Math.abs(v - value) < Math.abs(positions[best] - value) ? i : best), 0);
}

function typedNumber(text) { // with a point or a comma before its decimals; an error where it is none
  const typed = text.trim().replace("−", "-");
  if (/^[+-]?[1-9]\d{0,2}(,\d{3})+$/.test(typed)) {
    const cure = `write ${typed.replaceAll(",", "")} or ${typed.replace(",", ".")}`;
    throw new RangeError(`${text} has a comma of two meanings: ${cure}`);
  }
  const number = typed.replace(",", ".");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(number)) {
    throw new RangeError(`must be one number, got ${text || "nothing"}: write for example 0.5 or 2e4`);
  }
  const value = Number(number);
  if (!Number.isFinite(value)) throw new RangeError(`must be a finite number, got ${text}: write a smaller one`);
  return value;
}

const isTyped = (field) => document.activeElement === field; // into it: a result that arrives leaves it as it is

function refusalOf(...fields) { // [where a message stands, what shows it: why a value of the fields is not taken]
  const message = html("div", { className: "fl-message", role: "alert", hidden: true });
  return [message, (text) => {
    Object.assign(message, { textContent: text, hidden: !text });
    for (const field of fields) field.setAttribute("aria-invalid", String(Boolean(text)));
  }];
}

function row(about, children, kind) {
  const node = html("div", { className: `fl-control fl-${kind}`, title: about.hint ?? "" }, children);
  node.dataset.name = about.name; // any text, as parameters of automata have any name
  return node;
}

function numberControl(about, changed) { // it counts positions: a browser that computed values would round them
  const { name, label, unit, meaning, log } = about,
    id = `fl-number-${++numberControls}`;
  const usual = sliderPositions(about.low, about.high, about.value, log);
  const control = { name, about, positions: usual, value: about.value };
  const range = html("input", { type: "range", id, min: 0, step: 1, ariaLabel: meaning || name });
  const field = html("input", { type: "text", inputMode: "decimal", className: "fl-field",
    ariaLabel: `${meaning || name}, value`, spellcheck: false });
  const [message, refuse] = refusalOf(field);
  control.refuse = refuse;
  const shown = unit ? [html("span", { className: "fl-unit", textContent: shownUnit(unit) })] : [];
  control.node = row({ ...about, hint: `${meaning || name}${unit
    && `, ${shownUnit(unit)}`} (${name}, ${shortNumber(about.low)} to ${shortNumber(about.high)}${log
    ? ", logarithmic" : ""})` },
    [html("label", { htmlFor: id, className: "fl-label" }, [html("span", {}, labelNodes(label)), ...shown]), range,
      field, message], "number");
  control.show = (value) => {
    if (usual.includes(value)) control.positions = usual; // a value beyond the range widens it no longer
    else if (!control.positions.includes(value)) control.positions = sliderPositions(Math.min(about.low, value),
      Math.max(about.high, value), value, log && value > 0);
    const before = control.value;
    control.value = value;
    range.max = control.positions.length - 1;
    range.value = nearest(control.positions, value);
    range.ariaValueText = `${shortNumber(value, 7)} ${unit}`.trim();
    if (value !== before || !isTyped(field)) field.value = shortNumber(value, 7);
    refuse("");
  };
  function move(dragging) {
    const value = control.positions[Number(range.value)];
    if (value === control.value && dragging) return;
    control.value = value;
    range.ariaValueText = `${shortNumber(value, 7)} ${unit}`.trim();
    field.value = shortNumber(value, 7);
    refuse("");
    changed(name, value, dragging, true);
  }
  range.oninput = () => move(true);
  range.onchange = () => move(false);
  field.onchange = () => {
    if (field.value === shortNumber(control.value, 7)) return refuse("");
    try {
      const value = typedNumber(field.value);
      control.show(value);
      changed(name, value, false);
    } catch (error) {
      field.value = shortNumber(control.value, 7);
      refuse(`${name} ${error.message}. The value is still ${shortNumber(control.value, 7)}.`);
    }
  };
  control.show(about.value);
  return control;
}

function fieldControl(about, changed, field, kind, children, property = "value") { // one that has its value by itself
  let shown;
  field.onchange = () => changed(about.name, field[property], false);
  const show = (value) => {
    if (value !== shown || !isTyped(field)) field[property] = value;
    shown = value;
  };
  return { name: about.name, about, node: row(about, [html("label", {}, children)], kind), show };
}

function switchControl(about, changed) {
  const box = html("input", { type: "checkbox" });
  return fieldControl(about, changed, box, "switch", [box, ` ${about.text}`], "checked");
}

const textOfControl = ({ text }) => html("span", { className: "fl-text", textContent: text });

function choiceControl(about, changed) {
  const labels = about.labels ?? about.options,
    list = html("select", {}, about.options.map((value, i) => new Option(plainLabel(labels[i]), value)));
  return fieldControl(about, changed, list, "choice", [textOfControl(about), list]);
}

function textControl(about, changed) {
  const field = html("input", { type: "text", spellcheck: false });
  return fieldControl(about, changed, field, "text-field", [textOfControl(about), field]);
}

function formulaControl(about, changed) { // a text that is taken only where it can be read
  const { node, show, ...control } = textControl(about, (name, text, dragging) => {
    try {
      refuse("");
      changed(name, text.trim(), dragging);
    } catch (error) { refuse(error.message); }
  });
  const field = node.querySelector("input"), [message, refuse] = refusalOf(field);
  field.placeholder = EXAMPLE;
  node.append(message);
  return { ...control, node, refuse, show: (value) => { show(value); refuse(""); } };
}

function rangeControl(about, changed) { // two numbers, from and to
  const control = { name: about.name, about, value: about.value };
  const fields = ["from", "to"].map((which) =>
    html("input", { type: "text", inputMode: "decimal", className: "fl-field", ariaLabel: `${about.text}, ${which}` }));
  const [message, refuse] = refusalOf(...fields);
  for (const field of fields) {
    field.onchange = () => {
      refuse("");
      try {
        const value = fields.map(({ value: text }) => typedNumber(text));
        if (!(value[0] < value[1])) throw new RangeError("must go from a smaller to a larger number");
        control.value = value;
        changed(about.name, value, false);
      } catch (error) { refuse(`${about.name} ${error.message}`); }
    };
  }
  control.node = row(about, [html("span", { className: "fl-label" }, labelNodes(about.text)), ...fields, message],
    "range");
  control.show = (value) => { control.value = value;
    fields.forEach((field, i) => { field.value = shortNumber(value[i], 7); }); };
  return control;
}

const CONTROLS = { number: numberControl, switch: switchControl, choice: choiceControl, text: textControl,
  range: rangeControl, formula: formulaControl };
