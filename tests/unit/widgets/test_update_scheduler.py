"""The last value wins, and nothing is computed twice at once."""

import asyncio
import signal
import threading

import pytest

from frictionlab.widgets.update_scheduler import UpdateScheduler, in_this_thread

pytestmark = pytest.mark.plain_python


def nothing(_):
    pass


def test_changes_within_an_update_lead_to_one_more():
    value, seen = [0], []

    def update():
        seen.append(value[0])
        if len(seen) == 1:
            for value[0] in range(1, 6):
                scheduler.request()

    scheduler = UpdateScheduler(update, nothing)
    scheduler.request()
    assert seen == [0, 5]


def test_changes_from_another_thread_lead_to_one_more():
    value, seen, began, go_on = [0], [], threading.Event(), threading.Event()

    def update():
        seen.append(value[0])
        began.set()
        assert go_on.wait(60)

    scheduler = UpdateScheduler(update, nothing)
    worker = threading.Thread(target=scheduler.request)
    worker.start()
    assert began.wait(60)
    for value[0] in range(1, 6):
        scheduler.request()
    go_on.set()
    worker.join()
    assert seen == [0, 5]


def test_changes_that_other_threads_hear_while_a_cell_runs_are_one_update_in_its_thread():
    """JupyterLab hears widgets in threads of its own."""
    seen = []

    async def cell():
        scheduler = UpdateScheduler(lambda: seen.append(threading.get_ident()), nothing)
        for _ in range(5):
            worker = threading.Thread(target=scheduler.request)
            worker.start()
            worker.join()
        assert seen == []  # it is drawn when the cell is done
        await asyncio.sleep(0)

    asyncio.run(cell())
    assert seen == [threading.get_ident()]


def test_what_is_heard_after_the_event_loop_has_ended_is_done_where_it_is():
    async def cell():
        return in_this_thread(seen.append)

    seen = []
    heard = asyncio.run(cell())
    worker = threading.Thread(target=heard, args=(1,))
    worker.start()
    worker.join()
    assert seen == [1]


def test_an_update_that_fails_does_not_end_all_updates():
    calls = []

    def update():
        calls.append(None)
        if len(calls) == 1:
            raise KeyboardInterrupt

    scheduler = UpdateScheduler(update, nothing)
    with pytest.raises(KeyboardInterrupt):
        scheduler.request()
    scheduler.request()
    assert len(calls) == 2


def test_ctrl_c_between_and_after_updates_does_not_end_the_event_loop():
    calls, told = [], []

    def update():
        calls.append(None)
        if len(calls) == 1:
            scheduler.request()  # a newer value is computed all the same
            raise KeyboardInterrupt

    def stopped(error):
        signal.raise_signal(signal.SIGINT)  # a second click
        told.append(error)

    async def kernel():
        scheduler.request_later()
        await asyncio.sleep(0.1)

    scheduler = UpdateScheduler(update, stopped)
    asyncio.run(kernel())
    assert (len(calls), len(told)) == (2, 1)


def test_changes_that_are_held_count_as_one():
    calls = []
    scheduler = UpdateScheduler(lambda: calls.append(None), nothing)
    with scheduler.batch():
        scheduler.request()
        scheduler.request()
        assert calls == []
    assert len(calls) == 1
