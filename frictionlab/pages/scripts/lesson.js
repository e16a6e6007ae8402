// A lesson: steps of text, each with a state and the control that it is about. A lecturer records it by moving these.
// It is data, [{text, control, changed}], in a link or a file, and is replayed wherever the scene is shown.
const LESSON_FORMAT = "frictionlab lesson";

const changedValues = (state, { initial }) =>
  Object.fromEntries(differences(initial, state).map((name) => [name, state[name]]));

function lessonSteps(data, { initial }) { // those of a link or a file, with what controls of this scene can be set to
  if (!Array.isArray(data)) return [];
  const fits = ([name, value]) => name in initial && typeof value === typeof initial[name];
  return data.map(({ text, control, changed }) => ({ text: String(text), control: String(control),
    changed: Object.fromEntries(Object.entries(changed ?? {}).filter(fits)) }));
}

class Lesson {
  constructor(explorer, node) { Object.assign(this, { explorer, node, steps: [], place: 0, recording: false }); }

  play(steps, place = 0) { // from one of its steps; without steps there is none
    Object.assign(this, { steps, recording: false });
    if (steps.length) return this.go(Math.min(place, steps.length - 1));
    this.draw([]);
    if (this.explorer.result) this.explorer.record(); // without it in the link
  }

  go(place) {
    const { explorer, steps } = this, { text, control, changed } = steps[this.place = place];
    explorer.set({ ...explorer.scene.initial, ...changed });
    this.draw([html("p", { textContent: `Step ${place + 1} of ${steps.length}` }),
      html("p", { role: "status", className: "fl-step", textContent: text }),
      this.button("back", () => this.go(place - 1), !place),
      this.button("next", () => this.go(place + 1), place + 1 === steps.length),
      this.button("end the lesson", () => this.play([]))], control);
  }

  record(steps = []) { // each step has the state that is set and the control that was moved last
    Object.assign(this, { steps, recording: true });
    const field = html("textarea", { ariaLabel: "text of the step", rows: 3 });
    const add = () => {
      const { state, scene, moved } = this.explorer;
      if (!field.value.trim()) return field.focus();
      this.record([...steps, { text: field.value.trim(), control: moved, changed: changedValues(state, scene) }]);
    };
    this.draw([html("p", { textContent: `Steps so far: ${steps.length}. Move controls, then say what is to be `
      + "seen. The control that was moved last is marked." }), field, this.button("add step", add),
    this.button("finish", () => this.finish(), !steps.length), this.button("discard", () => this.play([]))]);
    if (steps.length) field.focus();
  }

  finish() {
    const { explorer: { scene }, steps } = this, content = { format: LESSON_FORMAT, model: scene.model,
      scene: scene.name ?? "", steps };
    this.explorer.save("lesson.json", "application/json", JSON.stringify(content, null, 1));
    this.play(steps);
    this.explorer.record(); // the link has it
  }

  button(text, does, disabled = false) {
    return html("button", { type: "button", textContent: text, onclick: does, disabled });
  }

  draw(children, control = "") {
    this.node.replaceChildren(...children);
    this.node.hidden = !children.length;
    for (const { name, node } of this.explorer.controls) {
      node.classList.toggle("fl-marked", name === control);
      if (name !== control) continue;
      const folded = node.closest("details");
      if (folded) folded.open = true;
      node.scrollIntoView({ block: "nearest" });
    }
  }
}
