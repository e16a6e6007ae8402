// Embedded pages take the site's theme: when they say that they are ready, and when it changes.
const siteTheme = () => ({ theme: document.documentElement.dataset.theme });
const livePages = () => document.querySelectorAll("figure.live-page iframe");
addEventListener("message", ({ data, source }) => { if (data === "frictionlab page") source.postMessage(siteTheme(), "*"); });
new MutationObserver(() => livePages().forEach((frame) => frame.contentWindow.postMessage(siteTheme(), "*"))).observe(document.documentElement, { attributeFilter: ["data-theme"] });
