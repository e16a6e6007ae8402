"""Progress bars can be switched off for all functions; what goes on inside is logged."""

import logging
import os
import subprocess
import sys
import textwrap
import time

import pytest

import frictionlab as fl
from frictionlab.interruption import PROGRESS_VARIABLE, Progress, progress_bar
from frictionlab.models.automaton_of_model import automaton_of_structure
from tests.helpers.cases import slow_but


def is_shown():
    return not progress_bar([1]).disable


def test_bars_are_shown_unless_they_are_switched_off():
    assert is_shown()
    assert progress_bar([1], shown=False).disable
    with fl.progress(False):
        assert not is_shown()
        with fl.progress(True):
            assert is_shown()
        assert not is_shown()
    assert is_shown()


def test_a_page_of_voila_has_no_bars(monkeypatch):
    """It would show in place of one that has vanished that a widget cannot be displayed."""
    monkeypatch.setenv("SERVER_SOFTWARE", "voila/0.5.8")
    assert not is_shown()
    monkeypatch.setenv("SERVER_SOFTWARE", "another/1.0")
    assert is_shown()


def test_without_a_block_the_switch_stays():
    before = fl.progress(False)
    assert not is_shown()
    with before:
        pass
    assert is_shown()


def test_a_run_says_nothing_of_the_compilation(capsys):
    with Progress(1.0, compiling=True):
        pass
    assert "compiling the solver" in capsys.readouterr().err
    with fl.progress(False), Progress(1.0, compiling=True):
        pass
    assert capsys.readouterr().err == ""


SAID = slow_but(
    [("off", False), ("1", True)], [("0", False), ("off", False), ("False", False), ("1", True)], several=True
)


@pytest.mark.parametrize(("value", "shown"), SAID)
def test_the_environment_switches_bars_off(value, shown):
    code = "from frictionlab.interruption import progress_bar; print(not progress_bar([1]).disable)"
    environment = os.environ | {PROGRESS_VARIABLE: value}
    answer = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == str(shown)


def test_models_modes_and_runs_are_logged(caplog):
    automaton_of_structure.cache_clear()
    with caplog.at_level(logging.DEBUG, logger="frictionlab"):
        derived = fl.TwoBlocks().automaton().derived()  # not as it is kept
        fl.solve(derived, 1.0, x0=[0.0, 0.0, 0.0, 0.0], progress=False)
    said = [(record.levelno, record.getMessage()) for record in caplog.records]
    assert any(level == logging.INFO and "automaton of TwoBlocks" in text for level, text in said)
    assert any(level == logging.DEBUG and text.startswith("deriving mode") for level, text in said)
    assert any(level == logging.DEBUG and text.startswith("run to 1 s") for level, text in said)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
@pytest.mark.parametrize("holder", ["child", "parent"])
def test_a_bar_does_not_wait_for_another_process(holder):
    """One that is killed while it holds the lock of its bars, or is forked while another thread holds it."""
    script = f"""
    import os, signal, threading
    from frictionlab.interruption import progress_bar
    list(progress_bar(range(3)))
    lock = type(progress_bar([1])).get_lock()
    if {holder == "child"}:
        child = os.fork()
        if not child:
            lock.acquire()
            os.kill(os.getpid(), signal.SIGKILL)
    else:
        thread = threading.Thread(target=lock.acquire)
        thread.start()
        thread.join()
        child = os.fork()
        if not child:
            list(progress_bar(range(3)))
            os._exit(0)
    status = os.waitpid(child, 0)[1]
    if {holder == "child"}:
        list(progress_bar(range(3)))
    print(status, threading.active_count())
    """
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(script)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stdout == ("9 1\n" if holder == "child" else "0 1\n"), done.stderr


def test_a_bar_of_slow_tasks_is_shown_at_each(capsys):
    """After fast ones too: nothing else looks at the time."""
    for i in progress_bar(range(2003), delay=0.0, mininterval=0.01):
        if i >= 2000:
            time.sleep(0.05)
    shown = capsys.readouterr().err
    assert "2002/2003" in shown
