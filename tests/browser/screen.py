"""What an explorer shows in a browser, and a hand on its controls."""

import time

PATIENCE = 60_000  # milliseconds
SEEN = """(root) => {
  const explorer = document.querySelector(root), texts = (of) => explorer.querySelector(of)?.innerText ?? "";
  const plots = explorer.querySelectorAll(".fl-panel:not(.fl-panel-mechanism) canvas.fl-canvas");
  return { pictures: [...plots].map((canvas) => canvas.toDataURL()), words: texts(".fl-numbers") };
}"""
BUSY = """(root) => [...document.querySelectorAll(root + " .fl-busy")].every((busy) => busy.hidden)"""


def seen(page, root):
    """What the explorer shows now: its plots, and the numbers of the equilibrium."""
    return page.evaluate(SEEN, root)


def press(page, root, name, key="ArrowRight"):
    """A key on a slider."""
    page.locator(f"{root} .fl-control[data-name={name}] input[type=range]").focus()
    page.keyboard.press(key)


def flip(page, root, name):
    """A click on a switch."""
    page.locator(f"{root} .fl-control[data-name=switch-{name}] input").click()


def wait_until(page, condition, arg=None):
    """Wait until an expression, or a function of `arg`, is true.

    Playwright's own function evaluates texts in the page, which the policy of exported pages forbids.
    """
    end = time.monotonic() + PATIENCE / 1000
    while not page.evaluate(condition, arg):
        assert time.monotonic() < end, f"{condition} of {arg}"
        page.wait_for_timeout(20)


def settled(page, root):
    """Wait until nothing is computed any more; returns what is seen then."""
    page.wait_for_timeout(400)  # the mark appears after 0.3 s
    wait_until(page, BUSY, root)
    last = seen(page, root)
    while True:
        page.wait_for_timeout(300)
        now = seen(page, root)
        if now == last:
            return now
        last = now


def changed(page, root, before, pictures=1, words=True):
    """Wait until so many pictures, and if asked the words, differ; returns what is seen once they stay."""
    end = time.monotonic() + PATIENCE / 1000
    while True:
        now = seen(page, root)
        different = sum(a != b for a, b in zip(before["pictures"], now["pictures"], strict=True))
        if different >= pictures and (not words or now["words"] != before["words"]):
            return settled(page, root)
        assert time.monotonic() < end, f"after {PATIENCE / 1000} s {root} still says {now['words']!r}"
        page.wait_for_timeout(100)


def come_to(page, expected, look):
    """Wait until `look()` gives what is expected; returns what it gives, that or the last it gave.

    A layout comes to rest over several frames, of which a slow machine draws a few a second.
    """
    end = time.monotonic() + PATIENCE / 2000
    while (now := look()) != expected and time.monotonic() < end:
        page.wait_for_timeout(100)
    return now


# Texts, fields, buttons and pictures that reach beyond the window or beyond a box that cuts them off.
CUT = """(root) => {
  const width = document.documentElement.clientWidth, found = [], box = (e) => e.getBoundingClientRect();
  const shown = (e) => e.checkVisibility({ visibilityProperty: true }) && box(e).width && box(e).height;
  const says = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
  for (const e of document.querySelectorAll(root + " *")) {
    if (!shown(e) || e.closest("option, sub, sup")) continue;
    if (!says(e) && !/^(INPUT|SELECT|BUTTON|TEXTAREA|IMG|CANVAS)$/.test(e.tagName)) continue;
    const b = box(e), name = `${e.tagName} ${e.className} "${(e.textContent || e.value || "").slice(0, 30)}"`;
    if (b.left < -0.5 || b.right > width + 0.5) found.push(`${name} leaves the window`);
    for (let p = e.parentElement; p && !p.matches(root); p = p.parentElement) {
      const q = box(p), style = getComputedStyle(p);
      const across = b.left < q.left - 0.5 || b.right > q.right + 0.5;
      const down = b.top < q.top - 2 || b.bottom > q.bottom + 2;
      if (style.overflowX !== "visible" && across) found.push(`${name} is cut across`);
      if (style.overflowY === "hidden" && down) found.push(`${name} is cut down`);
    }
  }
  return found;
}"""


def cut_off(page, root):
    """What is clipped within a part of the page."""
    return page.evaluate(CUT, root)


GRAVE = ("serious", "critical")
RUN_AXE = """async (root) => (await axe.run(root)).violations.map(({ id, impact, nodes }) => [impact,
  id, nodes.map((node) => node.html.slice(0, 120) + ": " + node.failureSummary).slice(0, 3)])"""


def faults(page, axe, root="html"):
    """The serious and critical faults that axe-core finds within a part of the page."""
    page.evaluate(axe)
    return [found for found in page.evaluate(RUN_AXE, root) if found[0] in GRAVE]
