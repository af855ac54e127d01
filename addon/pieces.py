"""Long work in pieces, so that Blender stays alive between them.

Such work is a generator.  Where it yields, Blender may draw and listen; what it yields to be done *beside*
(reading, arithmetic: nothing that touches ``bpy``) is done in a thread meanwhile, and its result comes back.
:func:`at_once` does it all here and now, :class:`InTurns` a little at each tick of a timer: both do the same
things in the same order.
"""

import time
from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from typing import Any

import bpy

type Pieces[T] = Generator[Callable[[], object] | None, Any, T]

SPEND_S = 0.03
"""Of Blender's main thread at each tick, and then to the end of the piece begun."""


def beside[T](work: Callable[[], T]) -> Generator[Callable[[], T], T, T]:
    """``found = yield from beside(work)``: have it done beside Blender; it must not touch bpy."""
    return (yield work)


def at_once[T](pieces: Pieces[T]) -> T:
    """All pieces, one after the other."""
    found: object = None
    with closing(pieces):
        while True:
            try:
                work = pieces.send(found)
            except StopIteration as end:
                return end.value
            found = None if work is None else work()


class InTurns:
    """Pieces of work, a few at each call of :meth:`turn`.

    Undo puts other datablocks in the place of those that the work knows: then it is begun anew.

    Args:
        begin: makes the pieces, looking up in ``bpy.data`` what it works on.
    """

    def __init__(self, begin: Callable[[], Pieces[None]]) -> None:
        self._begin, self._pieces = begin, begin()
        self._waiting: Future[object] | None = None
        self._thread = ThreadPoolExecutor(max_workers=1)
        self._undone = False
        for handlers in _undoing():
            handlers.append(self._note_undo)

    def turn(self) -> bool:
        """Go on for a moment; False when all is done.

        Raises:
            StageError: what the work refuses.
        """
        if self._undone:
            self._undone, self._waiting = False, None
            self._pieces.close()
            self._pieces = self._begin()
        more = False
        try:
            more = self._go_on()
        except ReferenceError:  # what it worked on was deleted, not undone
            self._undone = more = True
        finally:
            if not more:
                self.stop()
        return more

    def _go_on(self) -> bool:
        ends = time.monotonic() + SPEND_S
        while time.monotonic() < ends:
            if self._waiting is not None and not self._waiting.done():
                return True
            found, self._waiting = None if self._waiting is None else self._waiting.result(), None
            try:
                work = self._pieces.send(found)
            except StopIteration:
                return False
            self._waiting = None if work is None else self._thread.submit(work)
        return True

    def stop(self) -> None:
        """Go no further; what has been begun is taken back by the work itself."""
        for handlers in _undoing():
            if self._note_undo in handlers:
                handlers.remove(self._note_undo)
        self._pieces.close()
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _note_undo(self, *_: object) -> None:
        self._undone = True


def _undoing() -> tuple[list[Callable[..., None]], ...]:
    return bpy.app.handlers.undo_post, bpy.app.handlers.redo_post
