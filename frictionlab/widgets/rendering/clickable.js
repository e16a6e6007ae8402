// A picture that tells where it is clicked: shares of its width from the left and of its height from below.
function render({ model, el }) {
  const image = document.createElement("img");
  Object.assign(image.style, { display: "block", width: "100%", cursor: "crosshair" });
  let address = "";
  const show = () => {
    URL.revokeObjectURL(address);
    image.src = address = URL.createObjectURL(new Blob([model.get("value")], { type: "image/png" }));
    image.alt = image.title = model.get("hint");
  };
  image.addEventListener("click", (event) => {
    const box = image.getBoundingClientRect();
    model.send({ x: (event.clientX - box.left) / box.width, y: (box.bottom - event.clientY) / box.height });
  });
  model.on("change:value", show);
  show();
  el.append(image);
  return () => { // the view is taken off the page
    model.off("change:value", show);
    URL.revokeObjectURL(address);
  };
}

export default { render };
