"""Operators that start a process and look after it, whatever it does.

``invoke`` follows the process with a timer while Blender stays alive, and then brings in what it made, piece
by piece; ``execute`` waits for it, for scripts and tests.  Both show the same progress and end the same way.
"""

import time
from collections.abc import Mapping

import bpy

from pipeline.core.errors import StageError
from pipeline.progress import SHARES, Progress

from ..jobs import Job
from ..pieces import InTurns, Pieces, at_once
from ..properties.job import SHOWING
from ..wording import framed
from .base import Operator

TICK_S = 0.2
TURN_S = 0.02
"""From one turn of bringing results in to the next."""

GRACE_S = 1.5
"""A job that was asked to stop and still runs after this is ended."""

INTERRUPTED = 130


class Follower:
    """A job and what the window manager shows of it."""

    def __init__(
        self,
        job: Job,
        blocks: tuple[str, ...],
        shown: bpy.types.PropertyGroup,
        shares: Mapping[str, float] = SHARES,
    ) -> None:
        self.job, self.shown = job, shown
        self._progress = Progress(blocks, shares)
        self._asked: float | None = None
        self._told: dict[str, object] = {}

    def tick(self) -> bool:
        """Show what is new; False when the job has ended."""
        running = self.job.running()
        events = self.job.events()
        for event in events:
            self._progress.take(event)
        if events:
            last = events[-1]
            part = f"{last.segment}/{last.segments}" if last.segment else ""
            self._show(stage=last.stage, part=part, block=last.block)
        left = self._progress.seconds_left
        self._show(
            fraction=round(self._progress.fraction, 2),  # a hundredth is as wide as two pixels
            seconds_left=-1.0 if left is None else float(round(left)),
        )
        if running and self.shown.cancelling:
            self._cancel()
        return running

    def _show(self, **values: object) -> None:
        """Set what has changed, and draw the panels anew."""
        changed = {key: value for key, value in values.items() if value != self._told.get(key)}
        self._told |= changed
        if changed:
            self.shown.tell(**changed)

    def _cancel(self) -> None:
        now = time.monotonic()
        if self._asked is None:
            self._asked = now
            self.job.stop()
        elif now - self._asked > GRACE_S:
            self.job.kill()


class JobOperator(Operator):
    """An operator that runs a job; not registered itself.  Derived classes say which, and what comes then."""

    kind = ""
    shares: Mapping[str, float] = SHARES
    _follower: Follower | None = None
    _timer: bpy.types.Timer | None = None
    _showing: InTurns | None = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """One job at a time."""
        if context.window_manager.cabletwin_job.running:
            cls.poll_message_set("A job is running")
            return False
        return True

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Start the job.

        Returns:
            The job and the names of the blocks that its events may carry.

        Raises:
            StageError: it cannot be started.
        """
        raise NotImplementedError

    def show(self, context: bpy.types.Context, scene: bpy.types.Scene) -> Pieces[None]:
        """Bring what the job made into the scene that it was started from; by itself nothing."""
        yield from ()

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Take over what is quickly done, and say that it is."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Start and wait."""
        try:
            follower = self._follow(context)
        except StageError as error:
            return self._refuse(error)
        while follower.tick():
            time.sleep(TICK_S)
        wrong = self._wrong(follower)
        if wrong:
            return wrong
        try:
            at_once(self._shown(context, follower.shown.scene))
        except StageError as error:
            return self._refuse(error)
        return self._finish(context, follower.shown)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start and follow."""
        try:
            self._follower = self._follow(context)
        except StageError as error:
            return self._refuse(error)
        self._every(context, TICK_S)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look after the job on each tick, then bring in what it made; ESC asks to stop."""
        follower = self._follower
        if follower is None or self._timer is None:
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            follower.shown.tell(cancelling=True)
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        ended = self._turn(context, follower)
        if not ended:
            return {"PASS_THROUGH"}
        self._every(context, None)
        return ended

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender goes on to another file or ends: so does the job."""
        if self._follower is not None:
            self._follower.job.kill()
            if self._showing is not None:
                self._showing.stop()
            self._every(context, None)
            clear(self._follower.shown)

    def _turn(self, context: bpy.types.Context, follower: Follower) -> set[str]:
        """One tick; how it ended, or nothing as long as it goes on."""
        shown = follower.shown
        if self._showing is None:
            if follower.tick():
                return set()
            wrong = self._wrong(follower)
            if wrong:
                return wrong
            name = shown.scene
            shown.tell(running=True, stage=SHOWING, fraction=1.0)
            self._showing = InTurns(lambda: self._shown(context, name))
            self._every(context, TURN_S)
        if shown.cancelling:
            self._showing.stop()
            clear(shown)
            return self._cancelled()
        going_on = False
        try:
            going_on = self._showing.turn()
        except StageError as error:
            return self._refuse(error)
        finally:
            if not going_on:  # even after a surprise nothing is left running
                clear(shown)
                self._every(context, None)
        return set() if going_on else self._finish(context, shown)

    def _every(self, context: bpy.types.Context, seconds: float | None) -> None:
        """Be called so often; None: no more."""
        manager = context.window_manager
        if self._timer is not None:
            manager.event_timer_remove(self._timer)
            self._timer = None
        if seconds is not None:
            self._timer = manager.event_timer_add(seconds, window=context.window)

    def _refuse(self, error: StageError) -> set[str]:
        self.report({"ERROR"}, framed(str(error)))
        return {"CANCELLED"}

    def _follow(self, context: bpy.types.Context) -> Follower:
        job, blocks = self.start(context)
        shown = context.window_manager.cabletwin_job
        clear(shown)
        shown.tell(running=True, kind=self.kind, scene=context.scene.name, log=str(job.log))
        return Follower(job, blocks, shown, self.shares)

    def _wrong(self, follower: Follower) -> set[str]:
        """What came of a job that did not end well; nothing if it did."""
        outcome, shown = follower.job.outcome(), follower.shown
        cancelled = shown.cancelling or outcome.code == INTERRUPTED
        clear(shown)
        if outcome.code and not cancelled:
            shown.tell(failure=framed(outcome.failure))
            self.report({"ERROR"}, shown.failure)
            return {"CANCELLED"}
        return self._cancelled() if outcome.code else set()

    def _cancelled(self) -> set[str]:
        self.report({"INFO"}, "Cancelled: what is finished is kept")
        return {"CANCELLED"}

    def _shown(self, context: bpy.types.Context, name: str) -> Pieces[None]:
        """:meth:`show`, unless the scene is gone."""
        scene = bpy.data.scenes.get(name)
        if scene is not None:
            yield from self.show(context, scene)

    def _finish(self, context: bpy.types.Context, shown: bpy.types.PropertyGroup) -> set[str]:
        clear(shown)
        scene = bpy.data.scenes.get(shown.scene)
        try:
            if scene is not None:
                self.finished(context, scene)
        except StageError as error:
            return self._refuse(error)
        return {"FINISHED"}


def clear(shown: bpy.types.PropertyGroup) -> None:
    """Nothing runs."""
    for key in ("running", "cancelling", "stage", "part", "block", "fraction", "seconds_left", "failure"):
        shown.property_unset(key)
    shown.tell()
