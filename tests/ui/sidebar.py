"""A person at CableTwin's tab: finds its buttons and fields, opens its panels, chooses files.

Everything is done by mouse and keyboard; only looking (what lies under the pointer) asks Blender.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import bpy
from driver import Driver, Steps

PANELS = (
    *("survey", "lens", "pos", "reconstruct", "results", "crop"),
    *("mosaic", "measure", "export", "synthesise", "steel"),
)
HEAD_TOP_PX, HEAD_PX = 14, 28
"""Place of the first panel's head below the sidebar's top, and height of a closed panel, at scale 1."""

SUB_HEADS = 0.79
"""Height of a closed panel inside another one, in heights of a panel's head."""

COLUMNS = (0.5, 0.25, 0.75, 0.9)
"""Shares of a region's width at which a button is looked for."""

STEP_PX = 11
TAB_PX = 20
"""Width of the sidebar's tabs, at scale 1."""

ROW_PX, LINE_PX = 21, 20
"""Height of a list's row, and of a line of the file browser, at scale 1."""


class Person(Driver):
    """Knows the sidebar and the file browser."""

    def __init__(self, pictures: str) -> None:
        super().__init__(pictures)
        self._seen: dict[tuple[object, ...], tuple[int, int, int]] = {}
        self._path = ""

    def tab(self, name: str) -> Steps:
        """Open the 3D view's sidebar with N, and click its tabs from the top until the wanted one is open."""
        yield from self.over()
        yield from self.key("N")
        yield from self.wait_for(lambda: self.region().width > 1 and self._tab() != "UNSUPPORTED")
        region, scale = self.region(), bpy.context.preferences.system.ui_scale
        x = region.x + region.width - TAB_PX * scale / 2
        for y in range(int(region.y + region.height - TAB_PX * scale), region.y, -int(TAB_PX * scale)):
            yield from self.click(x, y)
            if self._tab() == name:
                return
        raise LookupError(f"no tab {name!r} in the sidebar")

    def _tab(self) -> str:
        return str(self.region().active_panel_category)

    def panel(self, name: str) -> Steps:
        """Open a closed panel or close an open one by its head; never two open at a time."""
        region, scale = self.region(), bpy.context.preferences.system.ui_scale
        top = region.y + region.height - HEAD_TOP_PX * scale
        yield from self.click(region.x + 60 * scale, top - HEAD_PX * scale * PANELS.index(name))
        yield 0.5

    def open_below(self, what: str, columns: tuple[float, ...], number: int = 0) -> Steps:
        """Click the head that follows a panel's last field, or one of the closed panels' after it."""
        _, y = yield from self.find(what, columns)
        region, scale = self.region(), bpy.context.preferences.system.ui_scale
        yield from self.click(region.x + 80 * scale, y - (1.15 + SUB_HEADS * number) * HEAD_PX * scale)
        yield 0.5

    def press(self, what: str, columns: tuple[float, ...] = COLUMNS, **where: str) -> Steps:
        """Click the button of an operator (a part of its command) or a field (the end of its path)."""
        spot = yield from self.find(what, columns, **where)
        yield from self.click(*spot)

    def fill(self, what: str, text: str, columns: tuple[float, ...] = (0.7, 0.85), **where: str) -> Steps:
        """Type a value into a field: Return over it, the value, Return."""

        def once() -> Steps:
            x, y = yield from self.find(what, columns, **where)
            self.move(x, y)
            yield 0.5
            yield from self.key("RET")
            yield from self.retype(text)

        yield from self.until(once, lambda: self._holds(text))

    def _holds(self, text: str) -> bool:
        """Whether the scene's property that was found last has this value; an angle is typed in degrees."""
        value = bpy.context.scene.path_resolve(self._path)
        if isinstance(value, str):
            return value == text
        shown = (value, math.degrees(value))  # Blender keeps 32 bits
        return any(math.isclose(v, float(text), rel_tol=1e-6, abs_tol=1e-6) for v in shown)

    def write(self, what: str, text: str, columns: tuple[float, ...] = (0.7, 0.85), **where: str) -> Steps:
        """Type a text into a field: a click into it, the text, Return."""
        yield from self.press(what, columns, **where)
        yield from self.key(
            "A", ctrl=True
        )  # only here: over a panel without a field it would close the panel
        yield from self.retype(text)

    def search(self, what: str, text: str, columns: tuple[float, ...]) -> Steps:
        """Choose from a field that opens a list with a search box."""
        yield from self.press(what, columns)
        yield 1.0
        yield from self.type(text)
        yield 0.8
        yield from self.key("RET")
        yield 0.4

    def find(
        self, what: str, columns: tuple[float, ...] = COLUMNS, area: str = "VIEW_3D", kind: str = "UI"
    ) -> Iterator[float]:
        """Centre of a button of a region; raises LookupError."""
        x, top, low = yield from self._span(what, columns, area, kind)
        return x, (top + low) // 2

    def row(self, what: str, number: int, column: float) -> Iterator[float]:
        """Place in a row of a list, the first being 0; the list is found by its index property."""
        yield from self.over(kind="UI", y=1.0)  # so that the first row is met first
        x, top, _ = yield from self._span(what, (column,), "VIEW_3D", "UI")
        return x, top - (number + 0.3) * ROW_PX * bpy.context.preferences.system.ui_scale

    def _span(self, what: str, columns: tuple[float, ...], area: str, kind: str) -> Iterator[float]:
        """Column, highest and lowest place at which it lies under the pointer."""
        place, region = self.area(area), self.region(area, kind)
        known = self._seen.get((what, area, columns))
        if known is not None:  # most things lie where they lay
            self.move(known[0], (known[1] + known[2]) // 2)
            yield 0.3
            if self._under_pointer(place, region, what):
                return known
        for column in columns:
            x, hits = region.x + int(region.width * column), []
            for y in self._places(region):
                self.move(x, y)
                yield 0.04
                if self._under_pointer(place, region, what):
                    hits.append(y)
                elif hits:
                    break
            if hits:
                top, low = yield from self._settle(place, region, what, x, hits[0])
                self._seen[what, area, columns] = (x, top, low)
                return x, top, low
        raise LookupError(f"no button {what!r} in {area} {kind}")

    def _settle(
        self, area: bpy.types.Area, region: bpy.types.Region, what: str, x: int, about: int
    ) -> Iterator[float]:
        """Highest and lowest place, looked at slowly: what is told may lag behind the pointer."""

        def there(y: int) -> Iterator[float]:
            self.move(x, y)
            yield 0.25
            return self._under_pointer(area, region, what)

        for steps in (0, 1, 2, 3, 4, 5, -1, -2):  # the pointer came from above
            middle = about + steps * STEP_PX
            if (yield from there(middle)):
                break
        else:
            raise LookupError(f"{what!r} was there and is gone")
        top = low = middle
        while (yield from there(top + STEP_PX)):
            top += STEP_PX
        while (yield from there(low - STEP_PX)):
            low -= STEP_PX
        return top, low

    def _places(self, region: bpy.types.Region) -> list[int]:
        """Heights to look at, from a little above the pointer downwards, then from the top."""
        places = list(range(region.y + region.height - 4, region.y, -STEP_PX))
        first = next((k for k, y in enumerate(places) if y < self._at[1] + 3 * STEP_PX), 0)
        return [*places[first:], *places[:first]]

    def _under_pointer(self, area: bpy.types.Area, region: bpy.types.Region, what: str) -> bool:
        manager = bpy.context.window_manager
        with self.override(area, region):
            if bpy.ops.ui.copy_python_command_button.poll():
                manager.clipboard = ""
                bpy.ops.ui.copy_python_command_button()
                if what in manager.clipboard:
                    return True
            under = bpy.context.property
        found = bool(under) and f".{under[1]}".endswith(f".{what}")
        self._path = under[1] if found else self._path
        return found

    def choose_file(self, path: Path, picture: str = "") -> Steps:
        """In the file browser: type the folder, click the file, confirm."""
        yield from self.choose_folder(path.parent, confirm=False)
        yield from self._click_file(path.name)
        if picture:
            yield from self.shot(picture)
        yield from self._confirm()

    def choose_folder(self, folder: Path, *, confirm: bool = True) -> Steps:
        """In the file browser: type the folder; confirm where the folder itself is wanted."""
        yield from self.wait_for(lambda: self.has_area("FILE_BROWSER"))
        yield from self.wait_for(lambda: self._files().params is not None)
        yield 0.8
        if Path(self._files().params.directory.decode()) != folder:
            yield from self.write("directory", f"{folder}/", area="FILE_BROWSER", columns=(0.6, 0.4, 0.8))
            yield from self.wait_for(lambda: Path(self._files().params.directory.decode()) == folder, 10)
            yield 0.8
        if confirm:
            yield from self._confirm()

    def type_file_name(self, name: str) -> Steps:
        """In the file browser: the name of a file that is to be written; its field tells no property."""
        line = self.region("FILE_BROWSER", "EXECUTE")
        for _ in range(2):  # the first click only leaves the field of the folder
            yield from self.click(line.x + 0.3 * line.width, line.y + 0.5 * line.height)
            yield 0.6
        yield from self.key("A", ctrl=True)
        yield from self.retype(name)
        yield from self.wait_for(lambda: self._files().params.filename == name, 5)
        yield from self._confirm()

    def _files(self) -> bpy.types.Space:
        return self.area("FILE_BROWSER").spaces.active

    def _click_file(self, name: str) -> Steps:
        """Down the list until the click has taken it."""
        region, scale = self.region("FILE_BROWSER", "WINDOW"), bpy.context.preferences.system.ui_scale
        x = region.x + 0.15 * region.width
        for y in range(int(region.y + region.height - LINE_PX * scale), region.y, -int(LINE_PX * scale / 2)):
            yield from self.click(x, y)
            if self._files().params.filename == name:
                return
        raise LookupError(f"no file {name!r} in the file browser")

    def _confirm(self) -> Steps:
        yield from self.press("file.execute", area="FILE_BROWSER", kind="EXECUTE", columns=(0.95,))
        yield from self.wait_for(lambda: not self.has_area("FILE_BROWSER"))
        yield 0.5
