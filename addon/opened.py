"""The run that a scene shows, read once and kept while nothing in its folder changes.

A slider that moves or a fit that is tried again must not read a hundred megabytes each time.  What is kept
can always be read again: it is let go when another file is loaded, and is never what a .blend relies on.
"""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError
from pipeline.opened import OpenedRun

from .segments import read_run

_kept: dict[tuple[str, int], OpenedRun] = {}
"""At most one run, by its folder and the time of its last change."""


def opened(scene: bpy.types.Scene) -> OpenedRun:
    """The run that this scene shows.

    Raises:
        StageError: none is shown, or it cannot be read.
    """
    folder = scene.cabletwin.results.folder
    if not folder:
        raise StageError("run", "no results are shown", "open a run folder in the panel Results")
    path = Path(bpy.path.abspath(folder))
    key = (str(path), _changed(path))
    if key not in _kept:
        _kept.clear()
        _kept[key] = read_run(path)
    return _kept[key]


def _changed(folder: Path) -> int:
    """Nanoseconds; a product without its stamp, or made again, changes it."""
    files = (folder / "options.json", folder / "products", *(folder / "products").glob("*.stamp"))
    return max((f.stat().st_mtime_ns for f in files if f.exists()), default=0)


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    _kept.clear()


def register() -> None:
    """Let go of the run when another file is loaded."""
    bpy.app.handlers.load_pre.append(_forget)


def unregister() -> None:
    """Stop that, and let go."""
    bpy.app.handlers.load_pre.remove(_forget)
    _kept.clear()
