"""A job is asked to stop, and ended with all that it started; Windows' part is played by stand-ins."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from tests.addon.shown_run import library

SLEEPER = "import time; time.sleep(60)"
PARENT = f"""
import signal, subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", {SLEEPER!r}])
print(child.pid, flush=True)
signal.signal(signal.SIGTERM, {{}})
time.sleep(60)
"""


@pytest.fixture
def processes(cabletwin):
    return library("processes")


def started(processes, code):
    return subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, **processes.start_options(windows=False)
    )


def gone(pid):
    """Ended; a zombie whose new parent has not looked yet counts as gone."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
def test_all_that_a_job_started_is_asked_to_stop_with_it(processes):
    job = started(processes, PARENT.format("signal.SIG_DFL"))
    child = int(job.stdout.readline())
    processes.ask_to_stop(job, windows=False)
    assert job.wait(5) == -signal.SIGTERM
    deadline = time.monotonic() + 5
    while not gone(child) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert gone(child)


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
def test_a_job_that_does_not_listen_is_ended_with_all_that_it_started(processes):
    job = started(processes, PARENT.format("signal.SIG_IGN"))
    child = int(job.stdout.readline())
    processes.end(job, windows=False)
    assert job.returncode == -signal.SIGKILL
    deadline = time.monotonic() + 5
    while not gone(child) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert gone(child)


def test_ending_what_has_ended_does_nothing(processes):
    job = started(processes, "pass")
    job.wait(10)
    processes.ask_to_stop(job, windows=False)
    processes.end(job, windows=False)
    assert job.returncode == 0


def test_on_windows_a_job_leads_a_group_with_a_hidden_window_in_blenders_console(processes):
    made = SimpleNamespace(dwFlags=0, wShowWindow=None)
    options = processes.start_options(windows=True, api=SimpleNamespace(STARTUPINFO=lambda: made))
    # a process without any window (CREATE_NO_WINDOW) has a console of its own and hears no Ctrl-Break
    assert options == {"creationflags": 0x200, "startupinfo": made}
    assert (made.dwFlags, made.wShowWindow) == (1, 0)


class Stand:
    """In place of a Windows process."""

    def __init__(self, shares_console):
        self.pid, self.told, self.shares_console, self.alive = 4711, [], shares_console, True

    def send_signal(self, number):
        if not self.shares_console:
            raise OSError(87, "The parameter is incorrect")
        self.told.append(number)

    def poll(self):
        return None if self.alive else 1

    def wait(self, timeout=None):
        assert not self.alive
        return 1


def test_on_windows_a_job_is_sent_ctrl_break(processes):
    job = Stand(shares_console=True)
    processes.ask_to_stop(job, windows=True)
    assert job.told == [getattr(signal, "CTRL_BREAK_EVENT", 1)]


def test_on_windows_a_job_that_shares_no_console_is_ended_with_its_tree(processes, monkeypatch):
    job, called = Stand(shares_console=False), []

    def run(words, **_):
        called.append(words)
        job.alive = False

    monkeypatch.setattr(processes.subprocess, "run", run)
    processes.ask_to_stop(job, windows=True)
    assert called == [["taskkill", "/PID", "4711", "/T", "/F"]]
