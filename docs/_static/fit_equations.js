// Equations that are wider than the text become smaller, down to three quarters; what is wider still scrolls.
// On phones they keep their size and scroll.
(() => {
  "use strict";
  const SMALLEST = 0.72, LEAST_WINDOW = 1200;

  function fit() {
    for (const box of document.querySelectorAll("div.math")) {
      const math = box.querySelector("math");
      if (!math) continue;
      math.style.fontSize = "";
      const share = box.clientWidth / box.scrollWidth;
      if (share < 1 && window.innerWidth >= LEAST_WINDOW) {
        math.style.fontSize = `${1.08 * Math.max(SMALLEST, share * 0.99)}em`; // 1.08: site.css
      }
    }
  }

  window.addEventListener("load", () => document.fonts.ready.then(fit));
  window.addEventListener("resize", fit);
})();
