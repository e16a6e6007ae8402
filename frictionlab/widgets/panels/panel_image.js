// A panel's picture.  If it has a hint, it reports where it is clicked: shares of its width from the left and of its height
// from below.  It is as wide as the panel, or pixel for pixel where that is nearly as wide, so that letters stay sharp.
const NEARLY = 0.9;

function render({ model, el }) {
  const image = document.createElement("img");
  let address = "";
  const show = () => {
    URL.revokeObjectURL(address);
    image.src = address = URL.createObjectURL(new Blob([model.get("value")], { type: "image/png" }));
    image.alt = model.get("alt");
    image.title = model.get("hint");
  };
  const fit = () => {
    const own = image.naturalWidth / (window.devicePixelRatio || 1), share = own / el.clientWidth;
    image.style.width = share > NEARLY && share <= 1 ? `${own}px` : "100%";
  };
  image.style.cssText = `display: block; margin: auto; ${model.get("hint") ? "cursor: crosshair" : ""}`;
  image.addEventListener("load", fit);
  image.addEventListener("click", (event) => {
    const box = image.getBoundingClientRect();
    if (model.get("hint")) model.send({ x: (event.clientX - box.left) / box.width, y: (box.bottom - event.clientY) / box.height });
  });
  const observer = new ResizeObserver(fit);
  observer.observe(el);
  model.on("change:value", show);
  show();
  el.append(image);
  return () => { // when the view is removed from the page
    observer.disconnect();
    model.off("change:value", show);
    URL.revokeObjectURL(address);
  };
}

export default { render };
