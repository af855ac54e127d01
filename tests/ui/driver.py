"""A person's hands and eyes at the window, by simulated events: moves, clicks, types, looks.

Needs ``blender --enable-event-simulate``.  x and y count from the window's lower left corner.  Runs inside
Blender; what to click is :mod:`sidebar`'s matter.
"""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import bpy

KEYS = {c: c.upper() for c in "abcdefghijklmnopqrstuvwxyz"}
DIGITS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")
KEYS |= {str(k): name for k, name in enumerate(DIGITS)}
KEYS |= {" ": "SPACE", ".": "PERIOD", ",": "COMMA", "-": "MINUS", "/": "SLASH", "_": "MINUS"}

TRIES, DRAG_STEPS = 3, 20

Steps = Iterator[float]
"""What a step yields is a pause in seconds, in which Blender draws and handles events."""


class Driver:
    """One window and the pointer in it.

    Args:
        pictures: folder for screenshots.
    """

    def __init__(self, pictures: str) -> None:
        self._pictures, self._at = pictures, (0, 0)
        os.makedirs(pictures, exist_ok=True)

    @property
    def window(self) -> bpy.types.Window:
        """The first window."""
        return bpy.context.window_manager.windows[0]

    def area(self, kind: str = "VIEW_3D") -> bpy.types.Area:
        """The first area of that kind."""
        return next(a for a in self.window.screen.areas if a.type == kind)

    def has_area(self, kind: str) -> bool:
        """Whether there is one of that kind."""
        return any(a.type == kind for a in self.window.screen.areas)

    def region(self, area: str = "VIEW_3D", kind: str = "UI") -> bpy.types.Region:
        """A region of an area."""
        return next(r for r in self.area(area).regions if r.type == kind)

    def override(self, area: bpy.types.Area | None = None, region: bpy.types.Region | None = None):
        """The context of a place in the window."""
        where = {"window": self.window, "screen": self.window.screen}
        where |= {"area": area} if area else {}
        return bpy.context.temp_override(**where, **({"region": region} if region else {}))

    def move(self, x: float, y: float) -> None:
        """Put the pointer there."""
        self._at = (int(x), int(y))
        self._event("MOUSEMOVE", "NOTHING")

    def over(self, area: str = "VIEW_3D", kind: str = "WINDOW", x: float = 0.5, y: float = 0.5) -> Steps:
        """Put the pointer over a region, at a share of its width and height."""
        region = self.region(area, kind)
        self.move(region.x + x * region.width, region.y + y * region.height)
        yield 0.3

    def click(self, x: float, y: float, *, ctrl: bool = False) -> Steps:
        """Press and release."""
        self.move(x, y)
        yield 0.2
        self._event("LEFTMOUSE", "PRESS", ctrl=ctrl)
        yield 0.1
        self._event("LEFTMOUSE", "RELEASE", ctrl=ctrl)
        yield 0.3

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> Steps:
        """Press, move in small steps, release."""
        self.move(*start)
        yield 0.5
        self._event("LEFTMOUSE", "PRESS")
        yield 0.2
        for step in range(1, DRAG_STEPS + 1):
            share = step / DRAG_STEPS
            self.move(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
            yield 0.1
        yield 0.5
        self._event("LEFTMOUSE", "RELEASE")
        yield 0.5

    def wheel(self, turns: int, *, ctrl: bool = False) -> Steps:
        """Turn the wheel where the pointer is, down for positive numbers."""
        for _ in range(abs(turns)):
            self._event("WHEELDOWNMOUSE" if turns > 0 else "WHEELUPMOUSE", "PRESS", ctrl=ctrl)
            yield 0.1
        yield 0.3

    def key(self, kind: str, *, ctrl: bool = False, shift: bool = False) -> Steps:
        """Press a key by Blender's name of it."""
        self._event(kind, "PRESS", ctrl=ctrl, shift=shift)
        self._event(kind, "RELEASE", ctrl=ctrl, shift=shift)
        yield 0.2

    def type(self, text: str) -> Steps:
        """Type letters into the field that has the focus."""
        for c in text:
            self._event(KEYS.get(c.lower(), "TEXTINPUT"), "PRESS", unicode=c, shift=c.isupper())
            self._event(KEYS.get(c.lower(), "TEXTINPUT"), "RELEASE")
        yield 0.3

    def retype(self, text: str) -> Steps:
        """Replace what the field that has the focus holds, which is all chosen at first, and leave it."""
        yield from self.type(text)
        yield from self.key("RET")
        yield 0.4

    def wait_for(self, condition: Callable[[], bool], seconds: float = 30, every: float = 0.2) -> Steps:
        """Wait until it is so; raises TimeoutError."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"still not so after {seconds} s: {condition}")
            yield every

    def until(self, steps: Callable[[], Steps], condition: Callable[[], bool], seconds: float = 8) -> Steps:
        """Do it, and do it again where nothing came of it: a busy machine swallows a click now and then."""
        for _ in range(TRIES):
            yield from steps()
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                if condition():
                    return
                yield 0.1
        raise TimeoutError(f"nothing came of it {TRIES} times: {condition}")

    def shot(self, name: str) -> Steps:
        """A picture of the whole window."""
        yield 0.4
        path = os.path.join(self._pictures, f"{name}.png")
        with self.override():
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
            if shutil.which("import"):  # a virtual screen: Blender's own screenshot is black there
                subprocess.run(["import", "-silent", "-window", "root", path], check=True)
            else:
                bpy.ops.screen.screenshot(filepath=path)
        yield 0.1

    def _event(self, kind: str, value: str, **more: object) -> None:
        self.window.event_simulate(type=kind, value=value, x=self._at[0], y=self._at[1], **more)


def play(steps: Steps, on_end: Callable[[BaseException | None], None]) -> None:
    """Run steps on a timer, so that Blender draws and handles events between them."""

    def tick() -> float | None:
        pause = None
        try:
            pause = next(steps, None)
        finally:
            if pause is None:  # the last step, or one that failed
                on_end(sys.exception())
        return pause

    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
