"""Jobs side by side give what they give one after the other; the run can be stopped from where it is told."""

import threading
import time

import pytest

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Event, silent
from pipeline.core.parallel import each_side_by_side, side_by_side, workers_for


def telling(number, steps=5, pause_s=0.002):
    def job(emit):
        for step in range(steps):
            emit(Event(stage="match", block=str(number), done=step, total=steps))
            time.sleep(pause_s)
        return number

    return job


def failing(cause, after_s=0.0):
    def job(emit):
        time.sleep(after_s)
        raise StageError("match", cause, "look again")

    return job


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_results_come_in_the_order_of_the_jobs(workers):
    jobs = [telling(n, pause_s=0.01 / (n + 1)) for n in range(6)]
    assert side_by_side(jobs, silent, workers) == list(range(6))


def test_jobs_overlap():
    """Each of two jobs waits for the other to have begun: one after the other they would wait for ever."""
    met = threading.Barrier(2, timeout=5)
    assert sorted(side_by_side([lambda _: met.wait()] * 2, silent, 2)) == [0, 1]


def test_every_event_is_told_in_the_calling_thread_and_in_each_job_s_order():
    told, threads = [], set()

    def emit(event):
        told.append((event.block, event.done))
        threads.add(threading.get_ident())

    side_by_side([telling(n) for n in range(3)], emit, 2)
    assert threads == {threading.get_ident()}
    for n in range(3):
        assert [done for block, done in told if block == str(n)] == list(range(5))


def test_cancelling_stops_every_job_at_its_next_event():
    def emit(event):
        raise Cancelled

    began = time.monotonic()
    with pytest.raises(Cancelled):
        side_by_side([telling(n, steps=10_000) for n in range(5)], emit, 2)
    assert time.monotonic() - began < 1


def test_the_failure_told_is_always_that_of_the_first_job_that_fails():
    jobs = [telling(0), failing("slow", after_s=0.05), failing("quick"), telling(3, steps=10_000)]
    began = time.monotonic()
    with pytest.raises(StageError, match="slow"):
        side_by_side(jobs, silent, 4)
    assert time.monotonic() - began < 2


def test_short_work_on_every_item_gives_the_results_in_order_and_the_first_failure():
    assert each_side_by_side(lambda n: 10 * n, range(5)) == [0, 10, 20, 30, 40]
    with pytest.raises(ZeroDivisionError):
        each_side_by_side(lambda n: 1 / n, [2, 1, 0])


def test_no_more_workers_than_jobs_and_at_least_one():
    assert workers_for(0) == workers_for(1) == 1
    assert 1 <= workers_for(2) <= 2
    assert 1 <= workers_for(100) <= 4
