"""A person at the window, played by simulated events: moves, clicks, types, looks.  Runs inside Blender.

Needs ``blender --enable-event-simulate``.  x and y count from the window's lower left corner.
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

HEAD_TOP_PX, HEAD_PX = 14, 28
"""Place of the first panel's head below the sidebar's top, and height of a closed panel, at scale 1."""

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

    def click(self, x: float, y: float, button: str = "LEFTMOUSE") -> Steps:
        """Press and release."""
        self.move(x, y)
        yield 0.2
        self._event(button, "PRESS")
        yield 0.1
        self._event(button, "RELEASE")
        yield 0.3

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> Steps:
        """Press at the one place and release at the other."""
        self.move(*start)
        yield 0.2
        self._event("LEFTMOUSE", "PRESS")
        for k in range(1, 6):
            yield 0.05
            self.move(*(a + (b - a) * k / 5 for a, b in zip(start, end, strict=True)))
        yield 0.1
        self._event("LEFTMOUSE", "RELEASE")
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

    def sidebar(self, tab: str) -> Steps:
        """Open the 3D view's sidebar on a tab."""
        self.area().spaces.active.show_region_ui = True
        yield from self.wait_for(lambda: self.region().width > 1 and self._has_tabs())
        self.region().active_panel_category = tab
        self.region().tag_redraw()
        yield 0.6

    def _has_tabs(self) -> bool:
        return self.region().active_panel_category != "UNSUPPORTED"

    def head(self, number: int) -> Steps:
        """Click the head of a panel of the tab, the first being 0, while all above it are closed."""
        region, scale = self.region(), bpy.context.preferences.system.ui_scale
        top = region.y + region.height - HEAD_TOP_PX * scale
        yield from self.click(region.x + 60 * scale, top - HEAD_PX * scale * number)
        yield 0.5

    def press(self, what: str, columns: tuple[float, ...] = (0.5, 0.25, 0.75, 0.9)) -> Steps:
        """Click the button of an operator (a part of its command) or property in the sidebar."""
        spot = yield from self.find(what, columns)
        yield from self.click(*spot)

    def find(self, what: str, columns: tuple[float, ...] = (0.5, 0.25, 0.75, 0.9)) -> Iterator[float]:
        """Centre of a button in the sidebar, scrolled into view where need be; raises LookupError."""
        area, region = self.area(), self.region()
        for column in columns:
            x, hits = region.x + int(region.width * column), []
            for y in range(region.y + region.height - 4, region.y, -6):
                self.move(x, y)
                yield 0.04
                if self._under_pointer(area, region, what):
                    hits.append(y)
                elif hits:
                    break
            if hits:
                return x, (hits[0] + hits[-1]) // 2
        raise LookupError(f"no button {what!r} in the sidebar")

    def _under_pointer(self, area: bpy.types.Area, region: bpy.types.Region, what: str) -> bool:
        manager = bpy.context.window_manager
        with self.override(area, region):
            if bpy.ops.ui.copy_python_command_button.poll():
                manager.clipboard = ""
                bpy.ops.ui.copy_python_command_button()
                if what in manager.clipboard:
                    return True
            under = bpy.context.property
        return bool(under) and under[1].rpartition(".")[2] == what

    def scroll(self, pixels: int) -> Steps:
        """Scroll the sidebar down by turning the wheel over it."""
        region = self.region()
        self.move(region.x + region.width // 2, region.y + region.height // 2)
        for _ in range(max(abs(pixels) // 60, 1)):
            self._event("WHEELDOWNMOUSE" if pixels > 0 else "WHEELUPMOUSE", "PRESS")
            yield 0.05
        yield 0.4

    def wait_for(self, condition: Callable[[], bool], seconds: float = 30, every: float = 0.2) -> Steps:
        """Wait until it is so; raises TimeoutError."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"still not so after {seconds} s: {condition}")
            yield every

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
