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

SETTLE_S = 2.0
"""Nothing is foretold before."""


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
        self._stage_began: dict[str, float] = {}
        self._parts: dict[str, dict[int, float]] = {}
        self.stage_fraction = self.fraction = 0.0
        self.seconds_left: float | None = None

    def take(self, event: Event) -> None:
        """Follow one event.

        A resumed run finds stages finished: they tell nothing but their end, and do not count as work done.
        """
        now = time.monotonic()
        if ends_stage(event) and event.stage not in self._stage_began:
            self._skipped += self._shares.get(event.stage, 0.0)
        self._stage_began.setdefault(event.stage, now)
        part = event.done / max(event.total, 1)
        if event.block in self._blocks:
            parts = self._parts.setdefault(event.stage, {})
            parts[self._blocks.index(event.block)] = part
            # blocks may go side by side, begun in order: one that was passed over was finished already
            known = [parts.get(n, float(n < max(parts))) for n in range(len(self._blocks))]
            part = sum(known) / len(known)
        self.stage_fraction = part
        self._foretell(event.stage, part, now)

    def stage_seconds(self, stage: str) -> float:
        """Time since the first event of a stage."""
        return time.monotonic() - self._stage_began[stage]

    def _foretell(self, stage: str, part: float, now: float) -> None:
        self.seconds_left = None
        shares = self._shares
        if stage not in shares:
            return
        names, whole = list(shares), sum(shares.values())
        done = sum(shares[n] for n in names[: names.index(stage)]) + part * shares[stage]
        self.fraction = max(self.fraction, done / whole)
        passed, made = now - self._began, done - self._skipped
        if passed >= SETTLE_S and made > 0:
            self.seconds_left = passed / made * (whole - done)


def ends_stage(event: Event) -> bool:
    """Whether this event closes a stage: the one that speaks for all blocks."""
    return event.done >= event.total and not event.block
