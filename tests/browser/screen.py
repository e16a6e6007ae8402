"""What an explorer shows in a browser, and a hand on its controls."""

import time

PATIENCE = 60_000  # milliseconds
SEEN = """async (root) => {
  const explorer = document.querySelector(root);
  const bytes = async (image) => new Uint8Array(await (await fetch(image.src)).arrayBuffer()).join();
  const pictures = await Promise.all([...explorer.querySelectorAll("img.fl-panel")].map(bytes));
  const numbers = [...explorer.querySelectorAll(".fl-equilibrium span")].map((e) => e.innerText);
  return { pictures, words: numbers.join(" ") };
}"""


def seen(page, root):
    """What the explorer shows now: bytes of its pictures, and the numbers of the equilibrium."""
    return page.evaluate(SEEN, root)


def press(page, root, name, key="ArrowRight"):
    """A key on a slider."""
    page.locator(f"{root} .fl-{name} [role=slider]").focus()
    page.keyboard.press(key)


def flip(page, root, name):
    """A click on a switch."""
    page.locator(f"{root} .fl-switch-{name} input").click()


def settled(page, root):
    """Wait until nothing is computed any more; returns what is seen then."""
    page.wait_for_timeout(400)  # the mark appears after 0.3 s
    page.wait_for_function(
        "(root) => getComputedStyle(document.querySelector(root + ' .fl-busy')).visibility === 'hidden'",
        arg=root,
        timeout=PATIENCE,
    )
    last = seen(page, root)
    while True:
        page.wait_for_timeout(300)
        now = seen(page, root)
        if now == last:
            return now
        last = now


def changed(page, root, before, pictures=1, words=True):
    """Wait until so many pictures, and if asked the words, differ; returns what is seen once they stay.

    They come in messages of their own, one after the other.
    """
    # Asked from here: a predicate that awaits is no predicate for Playwright, its promise counts as true.
    end = time.monotonic() + PATIENCE / 1000
    while True:
        now = seen(page, root)
        different = sum(a != b for a, b in zip(before["pictures"], now["pictures"], strict=True))
        if different >= pictures and (not words or now["words"] != before["words"]):
            return settled(page, root)
        assert time.monotonic() < end, f"after {PATIENCE / 1000} s {root} still says {now['words']!r}"
        page.wait_for_timeout(100)
