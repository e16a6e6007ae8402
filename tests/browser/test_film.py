"""A film in Voila leaves nothing behind that cannot be displayed."""

from importlib.util import find_spec

import pytest

from tests.browser.screen import PATIENCE
from tests.browser.servers import ANIMATED, free_port, serving, write_notebook

pytestmark = [pytest.mark.browser, pytest.mark.slow]


def test_a_film_is_shown_and_no_widget_is_missed(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila shows the film; it is not installed")
    port = free_port()
    arguments = ["voila", str(write_notebook(tmp_path, ANIMATED)), "--no-browser", f"--port={port}"]
    with serving(arguments, port, tmp_path) as address:
        page = browser.new_page()
        page.route(lambda url: not url.startswith((address, "blob:", "data:")), lambda route: route.abort())
        page.goto(address, wait_until="commit", timeout=PATIENCE)
        page.wait_for_selector(".animation img", timeout=4 * PATIENCE)
        page.wait_for_timeout(3000)
        assert page.get_by_text("Error displaying widget").count() == 0
        page.close()
