"""A run folder read back, finished or half finished: for people who look at it (Blender, scripts).

Takes the folder; gives each stage's product where it is there.  Makes nothing: :mod:`pipeline.product` does.
"""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.options import build
from pipeline.segments.plan import SEGMENTS

# the stages bring scipy and OpenCV with them, for which Blender must not wait when it starts
if TYPE_CHECKING:
    from pipeline.cable.adjust import Orientation
    from pipeline.cable.crop import Crop
    from pipeline.cable.joint import RingOrientation
    from pipeline.cable.lens_records import LensSolution
    from pipeline.cable.measure import Measurement
    from pipeline.cable.mosaic import Mosaic
    from pipeline.cable.records import CableOptions, FlatFrames
    from pipeline.cable.ring import Ring
    from pipeline.cable.surface import BlockSurface
    from pipeline.cable.texture import UnrolledPicture
    from pipeline.core.vocabulary import Array, FrameSequence


@dataclass(frozen=True, kw_only=True)
class OpenedBlock:
    """What is there of one block; None where a stage is not finished.

    Attributes:
        frames: as they came from the camera.
        lens: as it was estimated or stated, before any adjustment.
        flat: undistorted frames and their pinhole lens.
        orientation: of the ring where there is one, else of the block alone.
        surface, picture, crop: in the block's own frame.
        cable_from_block: (4, 4), metres; the identity as long as the blocks are not joined.
    """

    frames: FrameSequence
    lens: LensSolution | None
    flat: FlatFrames | None
    orientation: Orientation | None
    surface: BlockSurface | None
    picture: UnrolledPicture | None
    crop: Crop | None
    cable_from_block: Array

    @property
    def name(self) -> str:
        """The block's name."""
        return self.frames.block


@dataclass(frozen=True, kw_only=True)
class OpenedRun:
    """What is there of a run; None where a stage is not finished.

    Attributes:
        folder: absolute.
        options: that it was made with.
        blocks: in the survey's order.
        together: the adjustment of all blocks as one ring.
        mosaic, ring, measurement: of all blocks together.
        report: report.json.
    """

    folder: Path
    options: CableOptions
    blocks: tuple[OpenedBlock, ...]
    together: RingOrientation | None
    mosaic: Mosaic | None
    ring: Ring | None
    measurement: Measurement | None
    report: dict[str, Any] | None


def open_run(folder: Path) -> OpenedRun:
    """Read what is finished.

    Raises:
        StageError: no run folder, nothing finished yet, or written by another version of this program.
    """
    from pipeline.cable.joint import RingOrientation
    from pipeline.cable.measure import Measurement
    from pipeline.cable.mosaic import Mosaic
    from pipeline.cable.records import SurveyFrames
    from pipeline.cable.ring import Ring

    folder = folder.absolute()
    if not (folder / "products").is_dir():
        raise StageError("run", f"{folder} is no run folder", "choose a folder that a reconstruction wrote")
    if (folder / SEGMENTS).is_dir() and not (folder / "products" / "all-mosaic.npz").exists():
        raise StageError(
            "run",
            f"{folder} is a long survey that was worked off in segments",
            f"choose one of the folders in {folder / SEGMENTS}",
        )
    frames = _load(folder, "frames", SurveyFrames)
    if frames is None:
        raise StageError("run", f"nothing is finished in {folder}", "run the reconstruction first")
    mosaic, ring = _load(folder, "mosaic", Mosaic), _load(folder, "ring", Ring)
    together = _load(folder, "joint", RingOrientation)
    return OpenedRun(
        folder=folder,
        options=_options(whole_of(folder)),
        blocks=tuple(
            _block(folder, number, sequence, together, mosaic, ring)
            for number, sequence in enumerate(frames.sequences)
        ),
        together=together,
        mosaic=mosaic,
        ring=ring,
        measurement=_load(folder, "measure", Measurement),
        report=_json(folder / "report.json"),
    )


def _block(
    folder: Path,
    number: int,
    frames: FrameSequence,
    together: RingOrientation | None,
    mosaic: Mosaic | None,
    ring: Ring | None,
) -> OpenedBlock:
    from pipeline.cable.adjust import Orientation
    from pipeline.cable.crop import Crop
    from pipeline.cable.lens_records import LensSolution
    from pipeline.cable.records import FlatFrames
    from pipeline.cable.surface import BlockSurface
    from pipeline.cable.texture import UnrolledPicture
    from pipeline.report.block_model import cable_from_block

    name = frames.block
    alone = None if together else _load(folder, "adjust", Orientation, name)
    return OpenedBlock(
        frames=frames,
        lens=_load(folder, "lens", LensSolution, name),
        flat=_load(folder, "undistort", FlatFrames, name),
        orientation=together.blocks[number] if together else alone,
        surface=_load(folder, "surface", BlockSurface, name),
        picture=_load(folder, "texture", UnrolledPicture, name),
        crop=_load(folder, "crop", Crop, name),
        cable_from_block=cable_from_block(number, mosaic, ring.alignment) if mosaic and ring else np.eye(4),
    )


def _load[T](folder: Path, stage: str, kind: type[T], block: str = "all") -> T | None:
    file = folder / "products" / f"{block}-{stage}.npz"
    # a product without its stamp is being made again
    if not (file.exists() and file.with_suffix(".stamp").exists()):
        return None
    try:
        return store.load(kind, file, whole_of(folder))
    except FileNotFoundError as error:
        raise StageError(
            "run", f"{error.filename or file} of {folder.name} is gone", "run the reconstruction again"
        ) from error
    except (KeyError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise StageError(
            "run",
            f"{file.name} of {folder.name} is damaged or of another version of this program",
            "run the reconstruction again",
        ) from error


def whole_of(folder: Path) -> Path:
    """The run folder of the whole survey: of a segment two folders up, else the same.

    Names of files are kept relative to it.
    """
    return folder.parent.parent if folder.parent.name == SEGMENTS else folder


def _options(folder: Path) -> CableOptions:
    from pipeline.cable.records import CableOptions

    return build(CableOptions, _json(folder / "options.json") or {}, key="options")


def _json(path: Path) -> dict[str, Any] | None:
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise StageError("run", f"{path} cannot be read", "run the reconstruction again") from error
    return found
