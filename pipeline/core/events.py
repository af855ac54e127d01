"""Progress as a stream of small records.

A stage gets one ``emit`` and calls it often (at least every half second).  The command line draws a bar or
writes JSON lines, the add-on draws a panel, tests collect.  Cancelling is checked where progress is emitted:
an ``emit`` may raise :class:`~pipeline.core.errors.Cancelled`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace


@dataclass(frozen=True, kw_only=True)
class Event:
    """One step of progress.

    Attributes:
        stage: name of the stage, e.g. ``"match"``.
        done: units finished (frames, segments, iterations).
        total: units in all, at least 1.
        block: block that is worked on, or "" for all of them.
        message: one line for the log, or "".
        segment, segments: of a survey that is cut, the segment from 1 and how many there are; else 0.
    """

    stage: str
    done: int
    total: int
    block: str = ""
    message: str = ""
    segment: int = 0
    segments: int = 0


Emit = Callable[[Event], None]


def silent(event: Event) -> None:
    """Swallow the event: for callers that want no progress."""


def part(emit: Emit, first: float, last: float) -> Emit:
    """An ``emit`` for one part of a stage's work: what it calls 0 to 1 is ``first`` to ``last`` of the whole.

    So that a stage of several passes never goes back.
    """

    def tell(event: Event) -> None:
        share = first + (last - first) * event.done / event.total
        emit(replace(event, done=round(1000 * share), total=1000))

    return tell
