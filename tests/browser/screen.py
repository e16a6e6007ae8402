"""What an explorer shows in a browser, and a hand on its controls."""

PATIENCE = 60_000  # milliseconds
SEEN = """async (root) => {
  const explorer = document.querySelector(root);
  const bytes = async (image) => new Uint8Array(await (await fetch(image.src)).arrayBuffer()).join();
  const pictures = await Promise.all([...explorer.querySelectorAll("img.fl-panel")].map(bytes));
  return { pictures, words: explorer.querySelector(".fl-equilibrium").innerText };
}"""


def seen(page, root):
    """What the explorer shows now: bytes of its pictures, and the words about the equilibrium."""
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


def changed(page, root, before):
    """Wait for other pictures than those of before; returns what is seen once they stay."""
    page.wait_for_function(
        f"async ([root, before]) => (await ({SEEN})(root)).pictures.some((p, i) => p !== before[i])",
        arg=[root, before["pictures"]],
        timeout=PATIENCE,
    )
    return settled(page, root)
