"""How far a run is and how long it will still take, from its events; for the console's bar and Blender's."""

import time
from collections.abc import Mapping

from pipeline.core.events import Event

SHARES = {
    "frames": 6.0,
    "lens": 12.0,
    "pos": 0.1,
    "match": 16.0,
    "adjust": 5.0,
    "closing": 11.0,
    "joint": 8.0,
    "undistort": 6.0,
    "dense": 15.0,
    "surface": 0.3,
    "texture": 4.0,
    "crop": 0.2,
    "mosaic": 1.0,
    "ring": 4.0,
    "measure": 4.0,
    "report": 8.0,
}
"""Rough share of each stage in a run, timed on the scenario sway; only the time left hangs on it."""

STEEL_SHARES = {
    "clouds": 10.0,
    "targets": 20.0,
    "register": 2.0,
    "compare": 5.0,
    "tiles": 10.0,
    "members": 40.0,
    "measure": 1.0,
    "photos": 40.0,
    "fuse": 5.0,
    "report": 5.0,
}
"""The same for a steel survey, timed on four stations."""

ADJUSTED = "undistort"
"""A survey in segments goes through the stages before this with all of them, then through it and the rest."""

SETTLE_S = 2.0
"""Nothing is foretold before."""
LEAST_SHARE = 1e-4
"""Of the work; of a run that was resumed and has made nothing yet, only rounding is left."""


class Progress:
    """Follows a run.

    Args:
        blocks: names of the survey's blocks, in order: block-by-block stages count them.
        shares: rough share of each stage in the work, in its order.

    Attributes:
        stage_fraction: of the stage that the last event came from, 0 to 1.
        fraction: of the whole run, 0 to 1; never goes back.
        seconds_left: None until enough has passed to tell.
    """

    def __init__(self, blocks: tuple[str, ...], shares: Mapping[str, float] = SHARES) -> None:
        self._blocks, self._shares = blocks, shares
        self._began = time.monotonic()
        self._skipped = 0.0
        self._stage_began: dict[tuple[int, str], float] = {}
        self._parts: dict[tuple[int, str], dict[int, float]] = {}
        self.stage_fraction = self.fraction = 0.0
        self.seconds_left: float | None = None
        self._segments = 0
        self._ended: set[tuple[int, str]] = set()

    def take(self, event: Event) -> None:
        """Follow one event.

        A resumed run finds stages finished: they tell nothing but their end, and do not count as work done.
        """
        now, key = time.monotonic(), (event.segment, event.stage)
        if key in self._ended:
            return  # a finished stage that is only looked up again
        if ends_stage(event):
            self._ended.add(key)
        if ends_stage(event) and key not in self._stage_began:
            self._skipped += self._shares.get(event.stage, 0.0)
        self._stage_began.setdefault(key, now)
        part = event.done / max(event.total, 1)
        if event.block in self._blocks:
            parts = self._parts.setdefault(key, {})
            parts[self._blocks.index(event.block)] = part
            # blocks may go side by side, begun in order: one that was passed over was finished already
            known = [parts.get(n, float(n < max(parts))) for n in range(len(self._blocks))]
            part = sum(known) / len(known)
        self.stage_fraction = part
        self._foretell(event, part, now)

    def stage_seconds(self, event: Event) -> float:
        """Time since the first event of this one's stage."""
        return time.monotonic() - self._stage_began[event.segment, event.stage]

    def _foretell(self, event: Event, part: float, now: float) -> None:
        self.seconds_left = None
        if event.stage not in self._shares:
            return
        self._segments = max(self._segments, event.segments)
        before, whole = self._work(event.stage, event.segment)
        done = before + part * self._shares[event.stage]
        self.fraction = max(self.fraction, done / whole)
        passed, made = now - self._began, done - self._skipped
        if passed >= SETTLE_S and made > LEAST_SHARE * whole:
            self.seconds_left = passed / made * (whole - done)

    def _work(self, stage: str, segment: int) -> tuple[float, float]:
        """What is done before a stage of a segment begins, and the whole work."""
        shares = self._shares
        names, times = list(shares), max(self._segments, 1)
        before = sum(shares[n] for n in names[: names.index(stage)])
        if times == 1:
            return before, sum(shares.values())
        first = shares[names[0]]  # frames, of the whole survey once
        early = sum(shares[n] for n in names[: names.index(ADJUSTED)]) - first
        late = sum(shares.values()) - early - first
        whole = first + times * (early + late)
        earlier = (segment or times) - 1
        if names.index(stage) < names.index(ADJUSTED):
            return earlier * early + before, whole
        return first + times * early + earlier * late + before - early - first, whole


def ends_stage(event: Event) -> bool:
    """Whether this event closes a stage: the one that speaks for all blocks."""
    return event.done >= event.total and not event.block
