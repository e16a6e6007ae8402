"""In Voila: showing the explorer of any model changes no value, every number's round trip gives it back, and
what is typed is taken or refused in words."""

from importlib.util import find_spec

import pytest

import frictionlab as fl
from tests.browser.screen import PATIENCE
from tests.browser.servers import EVERY_MODEL, free_port, serving, write_notebook

pytestmark = [pytest.mark.browser, pytest.mark.slow]
COUNT = len(fl.list_models("classics"))

# Move each slider by one position, away from the end it may be at, and back; what the fields show before and
# after.
ROUND_TRIP = """async (root) => {
  const controls = [...document.querySelectorAll(root + " .fl-number:not([hidden])")].map((c) =>
    [c.querySelector("input[type=range]"), c.querySelector("input[type=text]")]);
  const fields = () => controls.map(([, field]) => field.value), before = fields();
  for (const [range] of controls) {
    const home = range.value, end = home === range.max;
    range.value = Number(home) + (end ? -1 : 1);
    range.onchange();
    await new Promise((done) => setTimeout(done, 150));
    range.value = home;
    range.onchange();
    await new Promise((done) => setTimeout(done, 50));
  }
  return { before, after: fields() };
}"""


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    """The explorers of all models on one page, shown and at rest."""
    if find_spec("voila") is None:
        pytest.skip("voila shows the explorers; it is not installed")
    folder, port = tmp_path_factory.mktemp("models"), free_port()
    arguments = ["voila", str(write_notebook(folder, EVERY_MODEL)), "--no-browser", f"--port={port}"]
    with serving(arguments, port, folder) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.route(lambda url: not url.startswith((address, "blob:", "data:")), lambda route: route.abort())
        page.set_default_timeout(PATIENCE)
        page.goto(address, wait_until="commit")
        for i in range(COUNT):
            page.wait_for_selector(f".model-{i} .fl-number input[type=range]", timeout=3 * PATIENCE)
        page.wait_for_timeout(2000)  # what the browser would say unasked it says at once
        yield page
        page.close()


def told(page, i):
    return page.locator(f".told-{i}").inner_text()


def test_showing_changes_no_value_of_any_model(page):
    assert [told(page, i) for i in range(COUNT)] == ["0 same"] * COUNT


@pytest.mark.parametrize("i", range(COUNT), ids=[row.call for row in fl.list_models("classics")])
def test_a_round_trip_of_every_number_gives_it_back(page, i):
    shown = page.evaluate(ROUND_TRIP, f".model-{i}")
    assert len(shown["before"]) > 3
    assert shown["after"] == shown["before"]
    least = len(shown["before"])  # two changes of a control may arrive as one
    page.wait_for_function(
        "([i, least]) => { const [n, s] = document.querySelector(`.told-${i}`).innerText.split(' ');"
        " return Number(n) >= least && s === 'same'; }",
        arg=[i, least],
        timeout=PATIENCE,
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,234", "a comma of two meanings"),
        ("abc", "must be one number"),
    ],
)
def test_what_is_no_number_is_refused_beside_the_control(page, text, words):
    control, before = page.locator(".model-0 .fl-control.fl-mu_k"), told(page, 0)
    field, message = control.locator("input[type=text]"), control.get_by_role("alert")
    value = field.input_value()
    field.fill(text)
    field.press("Enter")
    page.wait_for_function(
        "(words) => document.querySelector('.model-0 .fl-mu_k .fl-message').innerText.includes(words)",
        arg=words,
    )
    assert message.is_visible()
    assert field.input_value() == value
    assert field.get_attribute("aria-invalid") == "true"
    assert told(page, 0) == before


def test_a_decimal_comma_is_one(page):
    control = page.locator(".model-0 .fl-control.fl-mu_k")
    field, slider = control.locator("input[type=text]"), control.get_by_role("slider")
    for text, value in (("0,5", "0.5"), ("0.3", "0.3")):
        field.fill(text)
        field.press("Enter")
        page.wait_for_function(
            "(v) => document.querySelector('.model-0 .fl-mu_k [type=range]').ariaValueText === v",
            arg=value,
        )
        assert field.input_value() == value
    assert slider.get_attribute("aria-label") == "coefficient of kinetic friction"
    assert control.get_by_role("alert").count() == 0
    page.wait_for_function("document.querySelector('.told-0').innerText.endsWith('same')")
