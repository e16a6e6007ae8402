"""The last value wins, and nothing is computed twice at once."""

import asyncio
import threading
import time

import pytest

import frictionlab as fl
from frictionlab.plotting.figure import Drawing
from frictionlab.widgets.update_scheduler import (
    INDICATOR_DELAY,
    INDICATOR_TEXT,
    WAITING_TEXT,
    BusyIndicator,
    UpdateScheduler,
    in_this_thread,
)

pytestmark = pytest.mark.plain_python


def test_changes_within_an_update_lead_to_one_more():
    value, seen = [0], []

    def update():
        seen.append(value[0])
        if len(seen) == 1:
            for value[0] in range(1, 6):
                scheduler.request()

    scheduler = UpdateScheduler(update)
    scheduler.request()
    assert seen == [0, 5]


def test_changes_from_another_thread_lead_to_one_more():
    value, seen, began, go_on = [0], [], threading.Event(), threading.Event()

    def update():
        seen.append(value[0])
        began.set()
        assert go_on.wait(60)

    scheduler = UpdateScheduler(update)
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
        scheduler = UpdateScheduler(lambda: seen.append(threading.get_ident()))
        for _ in range(5):
            worker = threading.Thread(target=scheduler.request)
            worker.start()
            worker.join()
        assert seen == []  # it is drawn when the cell is done
        await asyncio.sleep(0)

    asyncio.run(cell())
    assert seen == [threading.get_ident()]


def test_a_slider_that_moves_while_a_cell_runs_is_told_to_wait():
    async def cell():
        explorer = fl.explore(fl.MassOnBelt(), panels=("phase",))
        busy, updates = explorer.busy.widget, explorer.updates
        worker = threading.Thread(target=lambda: setattr(explorer.controls["v"], "value", 0.7))
        worker.start()
        worker.join()
        time.sleep(2 * INDICATOR_DELAY)  # the cell runs
        assert (busy.value, busy.layout.visibility) == (WAITING_TEXT, "visible")
        assert explorer.updates == updates
        await asyncio.sleep(0.01)
        assert (busy.value, busy.layout.visibility) == (INDICATOR_TEXT, "hidden")
        assert explorer.updates == updates + 1
        assert explorer.model.v == 0.7

    asyncio.run(cell())


@pytest.mark.parametrize("pause", [0.0, 2 * INDICATOR_DELAY])
def test_how_far_a_computation_is_stays_in_sight_while_a_change_is_shown(pause):
    busy = BusyIndicator()
    with busy.show_while_busy():
        busy.left = 40, 300
    words = busy.widget.value
    assert "40 of 300" in words
    busy.show_waiting()  # a change heard by another thread
    time.sleep(pause)
    with busy.show_while_busy():
        assert (busy.widget.value, busy.widget.layout.visibility) == (words, "visible")
        busy.left = None
    assert (busy.widget.value, busy.widget.layout.visibility) == (INDICATOR_TEXT, "hidden")


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

    scheduler = UpdateScheduler(update)
    with pytest.raises(KeyboardInterrupt):
        scheduler.request()
    scheduler.request()
    assert len(calls) == 2


def test_changes_that_are_held_count_as_one():
    calls = []
    scheduler = UpdateScheduler(lambda: calls.append(None))
    with scheduler.batch():
        scheduler.request()
        scheduler.request()
        assert calls == []
    assert len(calls) == 1


def test_that_the_solver_is_compiled_first_is_said_while_it_is(monkeypatch):
    seen = []

    def own(result):
        indicator = explorers[0].busy.widget if explorers else None
        seen.append(indicator and (indicator.layout.visibility, indicator.value))
        return Drawing("x (m)", "y (m)")

    explorers = []
    explorers.append(fl.explore(panels=(own,)))
    monkeypatch.setattr("frictionlab.widgets.explorer.needs_compilation", lambda function: True)
    explorers[0].controls["mu_k"].value = 0.5
    monkeypatch.setattr("frictionlab.widgets.explorer.needs_compilation", lambda function: False)
    explorers[0].controls["mu_k"].value = 0.6
    said = "compiling the solver, once on this machine: some 30 s …"
    assert seen == [None, ("visible", said), ("hidden", "computing …")]
    assert explorers[0].busy.widget.layout.visibility == "hidden"
