"""The last value wins, and nothing is computed twice at once."""

import threading

import pytest

from frictionlab.widgets.latest import Latest

pytestmark = pytest.mark.plain_python


def test_changes_within_an_update_lead_to_one_more():
    value, seen = [0], []

    def update():
        seen.append(value[0])
        if len(seen) == 1:
            for value[0] in range(1, 6):
                latest.request()

    latest = Latest(update)
    latest.request()
    assert seen == [0, 5]


def test_changes_from_another_thread_lead_to_one_more():
    value, seen, began, go_on = [0], [], threading.Event(), threading.Event()

    def update():
        seen.append(value[0])
        began.set()
        assert go_on.wait(60)

    latest = Latest(update)
    worker = threading.Thread(target=latest.request)
    worker.start()
    assert began.wait(60)
    for value[0] in range(1, 6):
        latest.request()
    go_on.set()
    worker.join()
    assert seen == [0, 5]


def test_an_update_that_fails_does_not_end_all_updates():
    calls = []

    def update():
        calls.append(None)
        if len(calls) == 1:
            raise KeyboardInterrupt

    latest = Latest(update)
    with pytest.raises(KeyboardInterrupt):
        latest.request()
    latest.request()
    assert len(calls) == 2


def test_changes_that_are_held_count_as_one():
    calls = []
    latest = Latest(lambda: calls.append(None))
    with latest.held():
        latest.request()
        latest.request()
        assert calls == []
    assert len(calls) == 1
