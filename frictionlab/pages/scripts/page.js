// An exported page: the front end with the solver in the browser.
let explorer;

async function begin() {
  const root = document.getElementById("explorer");
  let solver;
  try { solver = await loadSolver();
  } catch (error) { root.textContent = `this browser cannot run the solver: ${error.message}`; return; }
  bindFunctions(solver);
  explorer = new Explorer(root, SCENE, new BrowserEngine(solver), { address: true });
  const asked = readLink(location.hash, SCENE), { state, plays, challenge, steps } = asked;
  Object.assign(explorer, { challenge, state });
  explorer.showState();
  explorer.compute(false);
  if (steps.length) explorer.follow(asked);
  if (plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) explorer.toggle();
  window.onhashchange = () => {
    if (location.hash.slice(1) !== linkText(explorer.state, SCENE, explorer)) explorer.follow(readLink(location.hash,
      SCENE));
  };
  let dark = false;
  window.onbeforeprint = () => { dark = explorer.dark; explorer.setTheme("light"); }; // paper is white
  window.onafterprint = () => explorer.setTheme(dark ? "dark" : "light");
  // from the page that embeds this one
  addEventListener("message", ({ data }) =>
    { if (["light", "dark"].includes(data?.theme)) explorer.setTheme(data.theme); });
  document.addEventListener("keydown", (event) => { if (event.target === document.body) explorer.key(event); });
  document.body.dataset.ready = "yes";
  if (parent !== window) parent.postMessage("frictionlab page", "*");
}

begin();
