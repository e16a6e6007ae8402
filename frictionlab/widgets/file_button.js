// A button that asks Python for a file, or a text, and gives it to the browser: as a download, or on the clipboard.
function render({ model, el }) {
  const button = document.createElement("button"), told = document.createElement("span");
  button.className = "jupyter-widgets jupyter-button widget-button";
  button.style.width = "auto";
  told.setAttribute("role", "status");
  told.style.cssText = "margin: 0 6px; line-height: 28px";
  el.style.whiteSpace = "nowrap";
  el.append(button, told);
  const show = () => Object.assign(button, { textContent: model.get("label"), title: model.get("hint") });
  const say = (text) => { told.textContent = text; };
  // On a page that is nothing but the explorer a text that follows an address becomes a whole link.
  const whole = (text) => text.startsWith("?") && document.body.dataset.voila ? location.origin + location.pathname + text : text;
  function take(content, buffers) {
    if (content.text !== undefined) {
      const text = whole(content.text), copied = navigator.clipboard ? navigator.clipboard.writeText(text) : Promise.reject(new Error());
      copied.then(() => say("copied"), () => say(`the browser forbids to copy; here it is: ${text}`));
      return;
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([buffers[0]], { type: content.type }));
    link.download = content.name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    say(`saved ${content.name}`);
  }
  button.onclick = () => { say(""); model.send({ asked: true }); };
  model.on("msg:custom", take);
  model.on("change:label", show);
  show();
  return () => { model.off("msg:custom", take); model.off("change:label", show); };
}

export default { render };
