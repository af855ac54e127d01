"""One frame before and after the lens correction, as two images that follow the lens while it is changed.

Takes the scene's shown block and frame; gives the library's before-and-after pictures as image datablocks.
They are redrawn once in each turn of Blender's loop at most, whatever has changed, and after undo.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import bpy

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import LambdaRadius, Lens

from ..gather import gather_blocks
from ..wording import framed

if TYPE_CHECKING:
    import numpy as np

    from pipeline.cable.survey import Block

LARGEST_PX = 1280
"""Wider frames are shown smaller: the picture has to follow a slider."""

NAMES = {"before": "CableTwin lens: before", "after": "CableTwin lens: after"}


def refresh_preview(scene: bpy.types.Scene) -> None:
    """Draw the shown block's frame before and after the correction; the images are made where they are not.

    Raises:
        StageError: the frame cannot be read, or the lens is none.
    """
    from pipeline.cable.lens_pictures import before_after_picture

    view = scene.cabletwin.lens
    frame, lens = preview_of(scene)
    pictures = before_after_picture(frame, lens, view.grid_cells if view.use_grid else 0)
    for key, picture in zip(("before", "after"), pictures, strict=True):
        if getattr(view, key) is None:
            setattr(view, key, bpy.data.images.new(NAMES[key], 8, 8, alpha=False))
        _fill(getattr(view, key), picture)
    if view.problem:
        view.problem = ""


def preview_of(scene: bpy.types.Scene) -> "tuple[np.ndarray, Lens]":
    """The frame (h, w, 3) uint8 blue-green-red and its lens, both smaller where the frame is large.

    Lambda is the shown one, also while it is not given to the reconstruction.

    Raises:
        StageError: see :func:`refresh_preview`.
    """
    import numpy as np

    view, shown = scene.cabletwin.lens, scene.cabletwin.survey.block()
    if shown is None:
        raise StageError("lens", "the survey has no blocks", "add one in the panel Survey")
    (block,) = gather_blocks(scene, shown.name).blocks
    source, changed = _source_of(block), _changed(block)
    frames = _count(source, changed)
    if view.frames != frames:
        view.frames = frames
    frame, width, height = _frame(source, changed, min(view.frame, frames - 1))
    spec = block.lens_spec
    if spec.division_lambda is None:
        spec = replace(spec, division_lambda=float(f"{shown.division_lambda:.7g}"))
    lens = replace(block, lens_spec=spec).lens(width, height)
    return np.asarray(frame), _smaller(lens, frame.shape[1], frame.shape[0])


def schedule() -> None:
    """Redraw the previews soon; nothing where nobody looks."""
    if next(_watched(), None) is not None and not bpy.app.timers.is_registered(refresh_due):
        bpy.app.timers.register(refresh_due, first_interval=0.0)


def refresh_due() -> None:
    """Redraw the previews of all scenes; what stands against it is kept as the panel's sentence."""
    for scene in list(_watched()):
        try:
            refresh_preview(scene)
        except StageError as error:
            scene.cabletwin.lens.problem = framed(str(error))
        for area in _areas():
            area.tag_redraw()


def editors(scene: bpy.types.Scene) -> list[bpy.types.Area]:
    """The image editors that show this scene's preview."""
    view = scene.cabletwin.lens
    pictures = {p for p in (view.before, view.after) if p is not None}
    return [a for a in _areas() if a.type == "IMAGE_EDITOR" and a.spaces.active.image in pictures]


def _watched() -> Iterator[bpy.types.Scene]:
    """The scenes whose preview is open somewhere; without a window, those that have one."""
    for scene in bpy.data.scenes:
        if scene.cabletwin.lens.after is not None and (bpy.app.background or editors(scene)):
            yield scene


def _areas() -> Iterator[bpy.types.Area]:
    for window in bpy.context.window_manager.windows:
        yield from window.screen.areas


def _fill(image: bpy.types.Image, picture: "np.ndarray") -> None:
    """Put a picture (h, w, 3) uint8 blue-green-red into an image of any size."""
    import cv2
    import numpy as np

    height, width = picture.shape[:2]
    if tuple(image.size) != (width, height):
        # far quicker than scaling what is overwritten anyway
        image.source = "GENERATED"
        image.generated_width, image.generated_height = width, height
    # Blender's first row is the lowest
    coloured = cv2.flip(cv2.cvtColor(picture, cv2.COLOR_BGR2RGBA), 0)
    image.pixels.foreach_set(np.multiply(coloured, np.float32(1 / 255), dtype=np.float32).ravel())
    image.update()


def _changed(block: "Block") -> int:
    """Time of the source's last change, so that a file written anew is read anew."""
    return block.source.stat().st_mtime_ns if block.source.exists() else 0


def _source_of(block: "Block") -> "Block":
    """The same block whatever its lens: what its frames depend on."""
    from pipeline.cable.survey import LensSpec

    return replace(block, lens_spec=LensSpec(focal_px=1.0), angle_deg=0.0)


@lru_cache(maxsize=8)
def _count(source: "Block", changed: int) -> int:
    from pipeline.cable.sources import count_frames

    return count_frames(source)


@lru_cache(maxsize=4)
def _frame(source: "Block", changed: int, index: int) -> "tuple[np.ndarray, int, int]":
    """The frame, smaller where it is large, and its own width and height."""
    import cv2

    from pipeline.cable.sources import read_frame

    image = read_frame(source, index).image
    height, width = image.shape[:2]
    if width > LARGEST_PX:
        size = (LARGEST_PX, round(height * LARGEST_PX / width))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return image, width, height


def _smaller(lens: Lens, width_px: int, height_px: int) -> Lens:
    """The lens that took the same picture with fewer pixels."""
    scale = width_px / lens.width_px
    x, y = lens.principal_point_px
    # in all units but the pixel itself lambda stays what it is
    per_unit = scale**-2 if lens.lambda_radius == LambdaRadius.PIXEL else 1.0
    return replace(
        lens,
        width_px=width_px,
        height_px=height_px,
        focal_px=lens.focal_px * scale,
        principal_point_px=(x * scale, y * scale),
        division_lambda=lens.division_lambda * per_unit,
    )


@bpy.app.handlers.persistent
def _follow(*_: object) -> None:
    schedule()


_HANDLERS = ("undo_post", "redo_post", "load_post")
"""What changes properties without telling them."""


def register() -> None:
    """Follow undo, and files that are loaded."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).append(_follow)


def unregister() -> None:
    """Stop that, and let go of frames."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(_follow)
    if bpy.app.timers.is_registered(refresh_due):
        bpy.app.timers.unregister(refresh_due)
    for cached in (_count, _frame):
        cached.cache_clear()
