"""Time for which the extension's own code holds Blender: its timer, its panels, what it draws over views.

Wraps functions of the installed extension while it watches; redraws by Blender itself are not counted.  What
counts is the processor's time, so that a machine with other work to do tells the same.  Runs inside Blender.
"""

import sys
import time
from collections.abc import Callable
from functools import wraps
from types import ModuleType
from typing import Any

import bpy

PACKAGE = "cabletwin"


class Stopwatch:
    """Within ``with``: how often and how long each function ran.

    Attributes:
        seconds: of each call, by the function's name.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, list[float]] = {}
        self._back: list[tuple[Any, str, Any]] = []

    def __enter__(self) -> "Stopwatch":
        """Begin to watch."""
        self._wrap(module("operators.following").Follower, "tick")
        self._wrap(module("pieces").InTurns, "turn")
        overlay = module("overlay")
        for name in ("_labels", "_legend"):
            self._wrap(overlay, name)
        for kind in bpy.types.Panel.__subclasses__():
            self._watch_panels(kind)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave everything as it was."""
        for owner, name, before in reversed(self._back):
            setattr(owner, name, before)

    @property
    def longest_s(self) -> float:
        """The longest single call."""
        return max((max(s) for s in self.seconds.values()), default=0.0)

    def table(self) -> str:
        """One line for each function: calls, mean and longest time."""
        rows = sorted(self.seconds.items(), key=lambda row: -max(row[1]))
        lines = [
            f"  {name:45} {len(s):5} calls, mean {1e3 * sum(s) / len(s):7.2f}, longest {1e3 * max(s):7.2f} ms"
            for name, s in rows
        ]
        return "\n".join(["own code, while it ran:", *lines])

    def _watch_panels(self, kind: type) -> None:
        if f".{PACKAGE}." in f"{kind.__module__}." and "draw" in vars(kind):
            self._wrap(kind, "draw")
        for below in kind.__subclasses__():
            self._watch_panels(below)

    def _wrap(self, owner: Any, name: str) -> None:
        before: Callable[..., Any] = getattr(owner, name)
        label = f"{getattr(owner, '__name__', owner).rpartition('.')[2]}.{name}"

        def clock(*words: object) -> object:
            began = time.thread_time()
            try:
                return before(*words)
            finally:
                self.seconds.setdefault(label, []).append(time.thread_time() - began)

        @wraps(before)
        def drawn(self: object, context: object) -> object:  # Blender counts the names of a panel's arguments
            return clock(self, context)

        timed = drawn if name == "draw" else clock
        self._back.append((owner, name, vars(owner)[name]))
        setattr(owner, name, timed)


def module(name: str) -> ModuleType:
    """A module of the installed extension, such as ``overlay``."""
    return next(m for key, m in sys.modules.items() if key.endswith(f".{PACKAGE}.{name}"))
