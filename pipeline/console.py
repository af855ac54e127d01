"""Progress for people and for programs, on stderr: a bar with the time left, or one JSON event a line."""

import json
import os
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import TextIO

from pipeline.core.errors import Cancelled
from pipeline.core.events import Emit, Event, silent
from pipeline.progress import SHARES, Progress, ends_stage

REDRAW_S = 0.1
BAR = 28


def emitter(style: str, blocks: tuple[str, ...], shares: Mapping[str, float] = SHARES) -> Emit:
    """The progress of a run: "bar", "json" or "none".

    Args:
        style: how to tell.
        blocks: names of the survey's blocks or stations, in order: stages that go one by one count them.
        shares: rough share of each stage in the work, in its order.

    Raises:
        Cancelled: out of what it gives, when the reader of stderr has gone.
    """
    if style == "none":
        return silent
    return _heard(_json_lines if style == "json" else _Bar(sys.stderr, blocks, shares))


def _heard(emit: Emit) -> Emit:
    """Cancel the run when nobody reads our progress any more: the program that started it has gone."""

    def tell(event: Event) -> None:
        try:
            emit(event)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())  # for all that is still to be said
            raise Cancelled from None

    return tell


def _json_lines(event: Event) -> None:
    told = {key: value for key, value in asdict(event).items() if event.segments or "segment" not in key}
    sys.stderr.write(json.dumps(told, ensure_ascii=False) + "\n")
    sys.stderr.flush()


class _Bar:
    """One line a stage; on a terminal it moves.  What a finished stage has to say follows as a note."""

    def __init__(self, stream: TextIO, blocks: tuple[str, ...], shares: Mapping[str, float]) -> None:
        self._stream, self._progress = stream, Progress(blocks, shares)
        self._drawn = time.monotonic()

    def __call__(self, event: Event) -> None:
        now, finished = time.monotonic(), ends_stage(event)
        self._progress.take(event)
        if self._stream.isatty() and (finished or now - self._drawn > REDRAW_S):
            self._draw(event, end="\n" if finished else "")
            self._drawn = now
        elif finished:
            self._stream.write(f"{_where(event)} {self._progress.stage_seconds(event):6.1f} s\n")
        if finished and event.message:
            self._stream.write(f"note: {event.message}\n")
        self._stream.flush()

    def _draw(self, event: Event, end: str) -> None:
        filled = round(BAR * self._progress.stage_fraction)
        bar = "█" * filled + "░" * (BAR - filled)
        left = self._progress.seconds_left
        words = "" if left is None else f"about {int(left // 60)}:{int(left % 60):02d} left"
        self._stream.write(f"\r\x1b[K{_where(event)} {bar} {event.block:10s} {words}{end}")


def _where(event: Event) -> str:
    """The stage, and where a survey is cut the segment, in columns."""
    counted = f" {event.segment:3d}/{event.segments}" if event.segments else ""
    return f"{event.stage:8s}{counted}"
