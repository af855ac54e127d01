"""One picture: poses camera and lamps, lets Cycles trace, reads the light, proves the lens.  Needs bpy."""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array, Lens
from synth.lens_camera import RAYS_CHECKED_MIN, camera_matrix, check_rays, set_lens
from synth.scene import Scene

Picture = NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class Moment:
    """What one exposure needs to know.

    Attributes:
        lens: true lens of the block.
        rotation, translation: true cam_from_world, (3, 3) and (3,).
        lamps_in_world: (lamps, 3) metres.
        seed: of the rays within the pixels; another one every frame, or their noise would stand still.
        samples: rays per pixel.
        name: for messages.
        rows: first row and the one after the last that are exposed; None is the whole picture.
    """

    lens: Lens
    rotation: Array
    translation: Array
    lamps_in_world: Array
    seed: int
    samples: int
    name: str
    rows: tuple[int, int] | None = None


def trace(built: Scene, moment: Moment, scratch: Path) -> tuple[Picture, Picture]:
    """Render one moment.

    Args:
        built: the scene.
        moment: where camera and lamps are.
        scratch: folder for the renderer's file.

    Returns:
        Linear light (height, width, 3) and the depth along the optical axis (height, width) in metres, 0
        where the pixel's central ray misses the cable.  Other rows than those asked for are 0.

    Raises:
        StageError: the renderer wrote nothing, or did not trace through the lens.
    """
    set_lens(built.camera, moment.lens)
    built.camera.matrix_world = camera_matrix(moment.rotation, moment.translation)
    built.sheath.place_lamps(moment.lamps_in_world)
    built.scene.cycles.seed = moment.seed
    built.scene.cycles.samples = moment.samples
    built.scene.update_tag()  # with persistent data Cycles would not see seed and samples otherwise
    _expose_rows(built.scene.render, moment)
    file = scratch / "light.exr"
    file.unlink(missing_ok=True)
    built.scene.render.filepath = str(file)
    with _interrupt_afterwards(), _quiet_stdout():
        bpy.ops.render.render(write_still=True)
    if not file.exists():
        raise StageError("render", f"Cycles wrote no picture of {moment.name}", "check the space on the disk")
    light, hits = _read(file)
    if moment.rows is None or np.count_nonzero(hits.any(axis=-1)) >= RAYS_CHECKED_MIN:
        check_rays(moment.lens, moment.rotation, moment.translation, hits.astype(float), moment.name)
    depth = hits.astype(float) @ moment.rotation[2] + moment.translation[2]
    return light, np.where(np.any(hits != 0.0, axis=-1), depth, 0.0).astype(np.float32)


def _expose_rows(render: bpy.types.RenderSettings, moment: Moment) -> None:
    """Limit the render to the moment's rows; Blender counts them from the bottom, as shares of the height."""
    first, end = moment.rows or (0, moment.lens.height_px)
    render.use_border, render.use_crop_to_border = moment.rows is not None, False
    render.border_min_x, render.border_max_x = 0.0, 1.0
    render.border_min_y = 1.0 - end / moment.lens.height_px
    render.border_max_y = 1.0 - first / moment.lens.height_px


def _read(file: Path) -> tuple[Picture, Picture]:
    """Light and first hits of a multi-part EXR, each (height, width, 3)."""
    channels: dict[str, Picture] = {}
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        for part in exr.parts:
            for name, channel in part.channels.items():
                channels[".".join(name.rsplit(".", 2)[-2:])] = channel.pixels
    light = np.stack([channels[f"Combined.{c}"] for c in "RGB"], axis=-1)
    return light, np.stack([channels[f"Position.{c}"] for c in "XYZ"], axis=-1)


@contextlib.contextmanager
def _interrupt_afterwards() -> Iterator[None]:
    """Hold Ctrl-C back until the renderer is through: Cycles would swallow the KeyboardInterrupt."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread gets signals
        return
    pressed: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Keep Blender's own lines off stdout, which belongs to the results."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
