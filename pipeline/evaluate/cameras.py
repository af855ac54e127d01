"""Exterior orientations against truth: as they stand in the cable frame, and after the best rigid fit.

Takes the run's sparse models (COLMAP format) and the true poses; gives errors away from the axis, around it
and along it.  An image belongs to the true frame whose number stands last in its name (000012.png: 12).
"""

import re
from pathlib import Path

import cv2  # noqa: F401 - must be loaded before pycolmap, or writing images aborts
import numpy as np
import pycolmap

from pipeline.core.errors import StageError
from pipeline.core.fits.similarity import fit_similarity
from pipeline.core.rotations import angle_between_deg, poses_from_centres, rotation_from_vector
from pipeline.core.vocabulary import Array, Poses
from pipeline.evaluate.documents import Document, read_document
from pipeline.evaluate.records import CameraComparison, CameraErrors

ARM_M = 0.01
"""Each camera enters the rigid fit with its centre and the ends of arms both ways along its axes: the centres
of one block lie on a line, about which only attitudes can hold it."""


SMALLEST_RECORD = 8
"""Bytes that a record in a binary file of COLMAP has at least."""


def compare_cameras(run_folder: Path, report: Document, truth: Document) -> CameraComparison:
    """Compare the frames of all blocks of the run; the truth may know of more (a camera that was lost).

    Raises:
        StageError: a block's sparse model is missing or has a frame or a name that the truth does not know.
    """
    blocks = truth.inside("poses")
    names = [block.text("name") for block in report.items("blocks")]
    if not names:
        raise report.error("blocks is empty")
    pairs = {name: _block_pairs(run_folder, report, blocks, name) for name in names}
    run = _joined([found for found, _ in pairs.values()])
    true = _joined([true for _, true in pairs.values()])
    fit = fit_similarity(_with_arms(run), _with_arms(true), with_scale=False)
    moved = {name: (_moved(found, fit.rotation, fit.translation), t) for name, (found, t) in pairs.items()}
    turned = angle_between_deg(np.eye(3), fit.rotation)
    shift = fit.apply(run.centres.mean(axis=0, keepdims=True))[0] - run.centres.mean(axis=0)
    return CameraComparison(
        as_they_stand=(*(_errors(n, r, t) for n, (r, t) in pairs.items()), _errors("all", run, true)),
        fitted=(
            *(_errors(n, r, t) for n, (r, t) in moved.items()),
            _errors("all", _moved(run, fit.rotation, fit.translation), true),
        ),
        fit_rotation_deg=float(turned),
        fit_translation_mm=float(1000 * np.linalg.norm(shift)),
    )


def _block_pairs(run_folder: Path, report: Document, blocks: Document, name: str) -> tuple[Poses, Poses]:
    """The block's poses of the run and the true ones, in the order of the frames."""
    found: dict[int, Array] = {}
    for folder, rotation, shift in _pieces(run_folder, report):
        found = _piece(folder / "blocks" / name, rotation, shift) | found
    true = {round(pose.number("frame")): pose.array("cam_from_world", 3, 4) for pose in blocks.items(name)}
    for frame in found:
        if frame not in true:
            raise blocks.error(f"poses.{name} has no frame {frame}, which is in the run")
    frames = sorted(found)
    return _poses([found[f] for f in frames]), _poses([true[f] for f in frames])


def _pieces(run_folder: Path, report: Document) -> list[tuple[Path, Array, Array]]:
    """The run, or the segments of a long one: each its folder, and the motion into the whole's frame."""
    if "segments" not in report:
        return [(run_folder, np.eye(3), np.zeros(3))]
    return [
        (
            run_folder / "segments" / segment.text("name"),
            rotation_from_vector([0.0, np.radians(segment.number("roll_deg")), 0.0]),
            np.array([0.0, segment.number("start_m"), 0.0]),
        )
        for segment in report.items("segments")
    ]


def _piece(block: Path, rotation: Array, shift: Array) -> dict[int, Array]:
    """Frame number to cam_from_world (3, 4) of one block's folder, in the frame of the whole."""
    found = _read_sparse(block / "sparse")
    frames = sorted(found)
    poses = _placed(_poses([found[f] for f in frames]), block / "placement.json")
    whole = _moved(poses, rotation, shift)
    stacked = np.concatenate([whole.rotations, whole.translations[..., None]], axis=2)
    return dict(zip(frames, stacked, strict=True))


def _placed(poses: Poses, placement: Path) -> Poses:
    """Poses of a block's own model in the cable frame; as they stand where the blocks were not joined."""
    if not placement.exists():
        return poses
    matrix = read_document(placement).array("cable_from_block", 4, 4)
    scale = np.cbrt(np.linalg.det(matrix[:3, :3]))
    rotations = poses.rotations @ (matrix[:3, :3] / scale).T
    centres = poses.centres @ matrix[:3, :3].T + matrix[:3, 3]
    return poses_from_centres(rotations, centres)


def _read_sparse(folder: Path) -> dict[int, Array]:
    """Frame number to cam_from_world (3, 4)."""
    remedy = "run the survey to its end"
    # asked first: COLMAP says what it misses in its own log, and takes memory for what a broken file claims
    if not any((folder / f"images.{ending}").is_file() for ending in ("bin", "txt")):
        raise StageError("evaluate", f"{folder} holds no sparse model", remedy)
    broken = StageError("evaluate", f"{folder} cannot be read as a COLMAP model", remedy)
    if not all(_count_is_possible(file) for file in folder.glob("*.bin")):
        raise broken
    try:
        model = pycolmap.Reconstruction(str(folder))
    except (RuntimeError, ValueError, MemoryError) as error:
        raise broken from error
    found: dict[int, Array] = {}
    for image in model.images.values():
        digits = re.findall(r"\d+", Path(image.name).stem)
        if not digits or int(digits[-1]) in found:
            raise StageError(
                "evaluate",
                f"{folder}: the image name {image.name} gives no frame number of its own",
                "name the images by their number",
            )
        if image.has_pose:
            found[int(digits[-1])] = np.asarray(image.cam_from_world().matrix(), dtype=np.float64)
    if not found:
        raise StageError("evaluate", f"{folder} holds no oriented image", remedy)
    return found


def _count_is_possible(file: Path) -> bool:
    """Whether a binary file of COLMAP is long enough for the number of records that it begins with."""
    with file.open("rb") as stream:
        head = stream.read(8)
    return len(head) == 8 and int.from_bytes(head, "little") * SMALLEST_RECORD <= file.stat().st_size


def _poses(matrices: list[Array]) -> Poses:
    stack = np.stack(matrices)
    return Poses(rotations=stack[:, :, :3], translations=stack[:, :, 3])


def _joined(parts: list[Poses]) -> Poses:
    return Poses(
        rotations=np.concatenate([part.rotations for part in parts]),
        translations=np.concatenate([part.translations for part in parts]),
    )


def _with_arms(poses: Poses) -> Array:
    """(7 n, 3) points: each centre and the ends of its six arms."""
    centres, arms = poses.centres, ARM_M * poses.rotations  # rows of cam_from_world are the camera's axes
    ends = [centres[:, None] + arms, centres[:, None] - arms]
    return np.concatenate([centres, *(end.reshape(-1, 3) for end in ends)])


def _moved(poses: Poses, rotation: Array, translation: Array) -> Poses:
    """Poses after the world has moved by x -> R x + t."""
    rotations = poses.rotations @ rotation.T
    return Poses(rotations=rotations, translations=poses.translations - rotations @ translation)


def _errors(name: str, run: Poses, true: Poses) -> CameraErrors:
    difference = 1000 * (run.centres - true.centres)
    outward = true.centres * [1.0, 0.0, 1.0]
    outward = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    along = np.array([0.0, 1.0, 0.0])
    around = np.cross(along, outward)
    turned = angle_between_deg(run.rotations, true.rotations)
    return CameraErrors(
        block=name,
        frames=len(run),
        radial_mm=_rms(np.sum(difference * outward, axis=1)),
        around_mm=_rms(np.sum(difference * around, axis=1)),
        along_mm=_rms(difference @ along),
        position_mm=_rms(np.linalg.norm(difference, axis=1)),
        attitude_deg=_rms(turned),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
