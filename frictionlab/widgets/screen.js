// A button for the full screen, and what Python has to know about the page: how many pixels wide a panel is, and whether
// the page is dark.
const PAUSE = 150; // milliseconds without a change after which a size is reported

function isDark(element) { // the background that is seen
  for (let e = element; e; e = e.parentElement) {
    const [r, g, b, a = 1] = getComputedStyle(e).backgroundColor.match(/[\d.]+/g).map(Number);
    if (a > 0.5) return 0.2126 * r + 0.7152 * g + 0.0722 * b < 100;
  }
  return false;
}

function render({ model, el }) {
  const button = document.createElement("button");
  Object.assign(button, { className: "jupyter-widgets jupyter-button widget-button", textContent: "full screen", title: "fill the screen; escape leaves it" });
  button.style.width = "auto";
  el.append(button);
  const explorer = () => el.closest(".fl-explorer"), outermost = () => el.closest(".fl-scenes") ?? explorer();
  let timer = null, picture = null;
  function tell() {
    const panel = explorer()?.querySelector(".fl-panel");
    if (!panel?.clientWidth) return;
    const dark = isDark(outermost());
    for (const each of [explorer(), outermost()]) each.classList.toggle("fl-dark", dark);
    model.set("pixels", Math.round(panel.clientWidth * (window.devicePixelRatio || 1)));
    model.set("dark", dark);
    model.save_changes();
  }
  const soon = () => { clearTimeout(timer); timer = setTimeout(tell, PAUSE); };
  const changed = () => {
    button.textContent = document.fullscreenElement?.contains(el) ? "leave full screen" : "full screen";
    soon();
  };
  const sizes = new ResizeObserver(() => {
    if (!picture && (picture = explorer()?.querySelector(".fl-picture"))) sizes.observe(picture);
    soon();
  });
  const themes = new MutationObserver(soon), dark = matchMedia("(prefers-color-scheme: dark)");
  button.onclick = () => document.fullscreenElement ? document.exitFullscreen() : outermost().requestFullscreen();
  sizes.observe(el);
  themes.observe(document.body, { attributes: true });
  dark.addEventListener("change", soon);
  document.addEventListener("fullscreenchange", changed);
  return () => {
    clearTimeout(timer);
    sizes.disconnect();
    themes.disconnect();
    dark.removeEventListener("change", soon);
    document.removeEventListener("fullscreenchange", changed);
  };
}

export default { render };
