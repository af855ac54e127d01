"""Progress for people and for programs, on stderr: a bar with the time left, or one JSON event a line."""

import json
import os
import sys
import time
from dataclasses import asdict
from typing import TextIO

from pipeline.core.errors import Cancelled
from pipeline.core.events import Emit, Event, silent

# rough share of each stage in a run, from timings of the demo survey; only the time left hangs on it
SHARES = {
    "frames": 10.0,
    "lens": 8.0,
    "pos": 0.1,
    "match": 20.0,
    "adjust": 16.0,
    "closing": 8.0,
    "joint": 9.0,
    "dense": 15.0,
    "surface": 1.0,
    "texture": 6.0,
    "crop": 0.2,
    "mosaic": 2.0,
    "ring": 3.0,
    "measure": 3.0,
    "report": 10.0,
}
REDRAW_S = 0.1
BAR = 28


def emitter(style: str, blocks: tuple[str, ...]) -> Emit:
    """The progress of a run: "bar", "json" or "none".

    Args:
        style: how to tell.
        blocks: names of the survey's blocks, in order: block-by-block stages count them.

    Raises:
        Cancelled: out of what it gives, when the reader of stderr has gone.
    """
    if style == "none":
        return silent
    return _heard(_json_lines if style == "json" else _Bar(sys.stderr, blocks))


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
    sys.stderr.write(json.dumps(asdict(event), ensure_ascii=False) + "\n")
    sys.stderr.flush()


class _Bar:
    """One line a stage; on a terminal it moves."""

    def __init__(self, stream: TextIO, blocks: tuple[str, ...]) -> None:
        self._stream, self._blocks = stream, blocks
        self._began = self._drawn = time.monotonic()
        self._skipped = 0.0
        self._stage_began: dict[str, float] = {}

    def __call__(self, event: Event) -> None:
        now = time.monotonic()
        finished = event.done >= event.total and not event.block
        if finished and event.stage not in self._stage_began:
            self._skipped += SHARES.get(event.stage, 0.0)
        self._stage_began.setdefault(event.stage, now)
        if self._stream.isatty() and (finished or now - self._drawn > REDRAW_S):
            self._draw(event, now, end="\n" if finished else "")
            self._drawn = now
        elif finished:
            seconds = now - self._stage_began[event.stage]
            self._stream.write(f"{event.stage:8s} {seconds:6.1f} s\n")
        self._stream.flush()

    def _draw(self, event: Event, now: float, end: str) -> None:
        part = event.done / max(event.total, 1)
        if event.block and len(self._blocks):
            part = (self._blocks.index(event.block) + part) / len(self._blocks)
        filled = round(BAR * part)
        left = self._left(event.stage, part, now)
        bar = "█" * filled + "░" * (BAR - filled)
        self._stream.write(f"\r\x1b[K{event.stage:8s} {bar} {event.block:10s} {left}{end}")

    def _left(self, stage: str, part: float, now: float) -> str:
        """Time left, once enough has passed to tell.

        A resumed run finds stages finished: they tell nothing but their end, and do not count as work done.
        """
        names = list(SHARES)
        if stage not in SHARES:
            return ""
        done = sum(SHARES[n] for n in names[: names.index(stage)]) + part * SHARES[stage]
        passed, made = now - self._began, done - self._skipped
        if passed < 2 or made <= 0:
            return ""
        seconds = passed / made * (sum(SHARES.values()) - done)
        return f"about {int(seconds // 60)}:{int(seconds % 60):02d} left"
