// The index of a folder of pages: a card for each scene, with a sketch of its mechanism at rest in straight springs.
function sketch({ mechanism: parts, parameters, states }, root, canvas) {
  const read = (name) => getComputedStyle(root).getPropertyValue(`--fl-${name}`).trim();
  const look = { dark: root.dataset.theme === "dark", ink: read("ink"), paper: read("paper"), grey: read("grey"),
    pale: read("pale"), letters: 11 };
  const names = [...states, "penetration", "normal_force", "friction_force"];
  const samples = samplesByName(Float64Array.of(0), Int32Array.of(0), names, names.map(() => Float64Array.of(0)));
  const structure = { states, modes: [""], colours: [look.grey] };
  const mechanism = parts.map((part) => ({ ...part, label: "" }));
  const picture = pictureOf({ samples, structure, parameters, mechanism }, look);
  const [c, width, height] = fit(canvas);
  picture.draw(c, width, height, picture.scene, picture.row(samples, 0));
}

function card(about, root) {
  const { name, page, reason, mechanism: shown } = about,
    canvas = html("canvas", { ariaHidden: "true", hidden: !shown });
  const title = reason ? html("strong", { textContent: name }) : html("a", { href: page, textContent: name });
  const text = reason ? `No page: ${reason}.` : `${about.about[0].toUpperCase()}${about.about.slice(1)}`;
  const node = html("li", { className: "fl-card" }, [canvas, title, html("p", { textContent: text })]);
  if (shown) new ResizeObserver(() => sketch(about, root, canvas)).observe(canvas);
  return node;
}

function showGallery() {
  const root = document.getElementById("explorer"), dark = matchMedia("(prefers-color-scheme: dark)");
  const topics = [...new Set(CARDS.map(({ topic }) => topic))], of = (topic) =>
    CARDS.filter((about) => about.topic === topic);
  root.classList.add("fl-explorer", "fl-gallery");
  const draw = () => {
    root.dataset.theme = dark.matches ? "dark" : "light";
    root.replaceChildren(html("h1", { className: "fl-title", textContent: document.title }),
      ...topics.flatMap((topic) => [html("h2", { textContent: topic }),
        html("ul", { className: "fl-cards" }, of(topic).map((about) => card(about, root)))]));
    document.body.dataset.ready = "yes";
  };
  dark.onchange = draw;
  draw();
}

showGallery();
