"""Independent pieces of work side by side, in threads, as if they had been done one after the other.

Takes jobs that tell their progress; gives their results in order.  OpenCV and numpy leave the interpreter
free while they compute, so threads are enough, and nothing is copied.  Progress is told in the calling
thread, from which alone a run is cancelled.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue

import cv2

from pipeline.core.errors import Cancelled
from pipeline.core.events import Emit, Event, silent

MOST_WORKERS = 4
"""Each block that is worked on holds its own pictures in memory."""


def workers_for(jobs: int) -> int:
    """How many jobs are worth doing at once on this machine."""
    return max(min(jobs, os.process_cpu_count() or 1, MOST_WORKERS), 1)


def side_by_side[T](jobs: Sequence[Callable[[Emit], T]], emit: Emit, workers: int) -> list[T]:
    """Do all jobs, ``workers`` at a time.

    A job that fails lets those before it finish, so that always the same failure is told: the first one's.

    Args:
        jobs: each is given the emit to tell its progress with, often; it raises Cancelled when to stop.
        emit: is called in this thread only; where it raises, all jobs are stopped.
        workers: threads.

    Returns:
        The results, in the order of the jobs.

    Raises:
        Exception: what ``emit`` or the first failing job raises.
    """
    if workers < 2 or len(jobs) < 2:
        return [job(emit) for job in jobs]
    told: SimpleQueue[Event | None] = SimpleQueue()
    last = [len(jobs)]  # jobs from this number on must stop

    def teller(number: int) -> Emit:
        def tell(event: Event) -> None:
            if number >= last[0]:
                raise Cancelled
            told.put(event)

        return tell

    with _opencv_alone(), ThreadPoolExecutor(workers) as pool:
        futures: list[Future[T]] = []
        try:
            for number, job in enumerate(jobs):
                futures.append(pool.submit(job, teller(number)))
                futures[-1].add_done_callback(lambda _: told.put(None))
            running = len(jobs)
            while running:
                event = told.get()
                if event is not None:
                    emit(event)
                    continue
                running -= 1
                failed = [number for number, future in enumerate(futures) if _failed(future)]
                last[0] = min([*failed, last[0]])
                for future in futures[last[0] + 1 :]:
                    future.cancel()
        finally:
            last[0] = 0
            for future in futures:
                future.cancel()
    return [future.result() for future in futures]


@contextmanager
def _opencv_alone() -> Iterator[None]:
    """OpenCV stays in the thread that calls it: threads of its own would only get in each other's way."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def each_side_by_side[T, R](work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """``work`` of every item, for work so short that it tells no progress."""

    def job(item: T) -> Callable[[Emit], R]:
        return lambda _: work(item)

    return side_by_side([job(item) for item in items], silent, workers_for(len(items)))


def _failed[T](future: Future[T]) -> bool:
    return future.done() and not future.cancelled() and future.exception() is not None
