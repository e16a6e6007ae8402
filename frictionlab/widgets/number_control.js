// A slider and a field for one number. The slider counts positions, whose values Python sends, so that it never computes a
// value: it reports one only when it is moved, and that is one of Python's own. What is typed goes to Python as text;
// Python takes it or says why not.
const shown = (value) => String(Number(value.toPrecision(7)));

function nearest(values, value) {
  let best = 0;
  values.forEach((one, i) => { if (Math.abs(one - value) < Math.abs(values[best] - value)) best = i; });
  return best;
}

function render({ model, el }) {
  const make = (tag, properties, style) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.style.cssText = style;
    return made;
  };
  const range = make("input", { type: "range", min: 0, step: 1 }, "flex: 1 1 80px; min-width: 0; margin: 0 6px 0 2px");
  const field = make("input", { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false, className: "widget-readout" },
    "flex: none; width: 6.2em; min-width: 0; box-sizing: border-box; text-align: right; font: inherit; color: inherit; background: transparent; border: 1px solid var(--jp-border-color1, #767676)");
  const message = make("div", { className: "fl-message" }, "flex: 1 1 100%; white-space: normal; line-height: 1.3; color: var(--jp-error-color1, #B00020)");
  range.setAttribute("role", "slider");
  message.setAttribute("role", "alert");
  // In a box of its own, as JupyterLab removes the display that is set on the element itself.
  const box = make("div", {}, "display: flex; flex-flow: row wrap; align-items: center; min-width: 0");
  box.append(range, field, message);
  el.append(box);

  function showValue() {
    const values = model.get("positions"), value = model.get("value");
    Object.assign(range, { max: values.length - 1, ariaValueText: `${shown(value)} ${model.get("unit")}`.trim() });
    range.value = nearest(values, value);
    field.value = shown(value);
  }
  function showTexts() {
    el.title = model.get("hint");
    range.ariaLabel = model.get("meaning");
    field.ariaLabel = `${model.get("meaning")}, as a number`;
    message.textContent = model.get("message");
    message.style.display = message.textContent ? "" : "none";
    field.ariaInvalid = String(Boolean(message.textContent));
  }
  function moved(event) {
    const value = model.get("positions")[Number(range.value)];
    field.value = shown(value);
    if (event.type === "input" && !model.get("continuous_update")) return;
    if (value === model.get("value")) return;
    model.set("value", value);
    model.save_changes();
  }
  function typed() {
    const text = field.value;
    field.value = shown(model.get("value"));
    if (text !== field.value) model.send({ typed: text });
  }
  range.addEventListener("input", moved);
  range.addEventListener("change", moved);
  field.addEventListener("change", typed);
  field.addEventListener("focus", () => field.select());
  // A notebook takes keys for its own commands, arrows too.
  el.addEventListener("keydown", (event) => event.stopPropagation());
  for (const name of ["value", "positions", "unit"]) model.on(`change:${name}`, showValue);
  for (const name of ["meaning", "hint", "message"]) model.on(`change:${name}`, showTexts);
  showValue();
  showTexts();
  return () => {
    for (const name of ["value", "positions", "unit"]) model.off(`change:${name}`, showValue);
    for (const name of ["meaning", "hint", "message"]) model.off(`change:${name}`, showTexts);
  };
}

export default { render };
