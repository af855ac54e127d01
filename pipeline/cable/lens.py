"""Stage *lens*: which division lens took the frames, and the frames without its distortion.

Takes a block's frames and the lens as stated; gives the lens to work with (stated, estimated from the cable's
own edges, or left uncorrected on purpose) and undistorted frames.  The paper's section 3.2, equations (12) to
(15).  Leaves out calibration from a chessboard (:mod:`pipeline.cable.chessboard`) and the pictures for the
report (:mod:`pipeline.cable.lens_pictures`).
"""

from dataclasses import replace
from math import asin, tan
from pathlib import Path

import cv2
import numpy as np

from pipeline.cable.lens_records import CableScene, LensMethod, LensOptions, LensSolution
from pipeline.cable.plumb_lines import fit_plumb_lines
from pipeline.cable.plumb_records import PlumbEdges, PlumbLineFit, PlumbScene
from pipeline.cable.silhouette import Silhouette, find_silhouette
from pipeline.core.division import check, pixels_to_rays, radius_unit_px, undistorted_lens, undistortion_maps
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import frame_compression, write_png
from pipeline.core.pictures import read_colour
from pipeline.core.vocabulary import FrameSequence, Lens, TravelDirection

__all__ = [
    "CableScene",
    "LensMethod",
    "LensOptions",
    "LensSolution",
    "solve_lens",
    "undistort_frames",
]


def solve_lens(
    frames: FrameSequence,
    lens: Lens,
    lambda_known: bool,
    travel_in_image: TravelDirection,
    options: LensOptions,
    emit: Emit,
    *,
    scene: CableScene,
) -> LensSolution:
    """Settle the lens of a block.

    Args:
        frames: as they came from the camera.
        lens: as stated; lambda counts only where known.
        lambda_known: lambda is stated.
        travel_in_image: the cable runs along this direction.
        options: see there.
        emit: progress, one step a frame.
        scene: travel and stand-off.

    Raises:
        StageError: the lens folds, a frame is unreadable, or no cable is seen (naming block and frame).
    """
    estimate = options.correct and not lambda_known
    if not estimate:
        lens = lens if options.correct else replace(lens, division_lambda=0.0, lambda_sigma=0.0)
        check(lens)
        share = options.missing_share if options.need_outline else 1.0
        options = replace(options, most_frames=3, missing_share=share)
    found = _silhouettes(frames, lens, travel_in_image, options, scene, emit)
    fit = None
    if estimate:
        about = _scene(frames, lens, travel_in_image, scene)
        fit = fit_plumb_lines(_edges(found, lens, travel_in_image), about, options.plumb_lines)
        lens = _with_lambda(lens, fit)
        check(lens)
    stated = LensMethod.GIVEN if options.correct else LensMethod.NONE
    return LensSolution(
        lens=lens,
        method=LensMethod.PLUMB_LINES if estimate else stated,
        apparent_radius_m=_apparent_radius_m(found, lens, travel_in_image, scene),
        plumb_lines=fit,
    )


def _with_lambda(lens: Lens, fit: PlumbLineFit) -> Lens:
    """The lens with the lambda that was fitted, in its own unit."""
    per_unit = (radius_unit_px(lens) / (np.hypot(lens.width_px, lens.height_px) / 2)) ** 2
    return replace(
        lens,
        division_lambda=float(fit.lambda_half_diagonal * per_unit),
        lambda_sigma=float(fit.sigma * per_unit),
    )


def undistort_frames(
    frames: FrameSequence, lens: Lens, folder: Path, emit: Emit
) -> tuple[FrameSequence, Lens]:
    """Write the frames as a pinhole camera would have taken them, ``folder/STEM.png``.

    Returns:
        The new sequence and its lens, whose canvas is that of
        :func:`~pipeline.core.division.undistorted_lens`.

    Raises:
        StageError: a frame cannot be read, or the folder cannot be written.
    """
    pinhole = undistorted_lens(lens)
    maps = undistortion_maps(lens, pinhole)
    compression = frame_compression(len(frames), pinhole.width_px, pinhole.height_px)
    files = []
    for done, file in enumerate(frames.files):
        emit(Event(stage="undistort", done=done, total=len(frames), block=frames.block))
        image = cv2.remap(
            read_colour(file, "undistort"), *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_CONSTANT
        )
        files.append(folder / f"{file.stem}.png")
        write_png(files[-1], image, compression, stage="undistort")
    emit(Event(stage="undistort", done=len(frames), total=len(frames), block=frames.block))
    undistorted = replace(frames, files=tuple(files), width_px=pinhole.width_px, height_px=pinhole.height_px)
    return undistorted, pinhole


def _silhouettes(
    frames: FrameSequence,
    lens: Lens,
    travel: TravelDirection,
    options: LensOptions,
    scene: CableScene,
    emit: Emit,
) -> dict[int, Silhouette]:
    """Outlines by frame; frames without one are passed over as long as they are few."""
    chosen = np.unique(
        np.linspace(0, len(frames) - 1, min(options.most_frames, len(frames))).round().astype(int)
    )
    width = None if scene.diameter_m is None else _expected_width_px(lens, scene.diameter_m, scene.standoff_m)
    found: dict[int, Silhouette] = {}
    missing: list[StageError] = []
    for done, k in enumerate(chosen):
        emit(Event(stage="lens", done=done, total=len(chosen), block=frames.block))
        name = f"{frames.block}, frame {frames.source_indices[k]} ({frames.files[k].name})"
        try:
            found[int(k)] = find_silhouette(
                read_colour(frames.files[k], "lens"), travel, options.silhouette, width, name
            )
        except StageError as error:
            if "shows no cable" not in error.cause:
                raise
            missing.append(error)
    emit(Event(stage="lens", done=len(chosen), total=len(chosen), block=frames.block))
    if len(missing) > options.missing_share * len(chosen):
        raise missing[0]
    return found


def _expected_width_px(lens: Lens, diameter_m: float, standoff_m: float) -> float:
    """Width of a cylinder's outline: twice f tan(asin(r / D))."""
    ratio = min(diameter_m / 2 / standoff_m, 0.95)
    return 2 * lens.focal_px * tan(asin(ratio))


def _apparent_radius_m(
    found: dict[int, Silhouette], lens: Lens, travel: TravelDirection, scene: CableScene
) -> float:
    """Median over the frames of D sin(b), where the rays that touch the cable enclose the angle 2 b."""
    across = 0 if travel in (TravelDirection.UP, TravelDirection.DOWN) else 1
    half_angles = []
    for silhouette in found.values():
        limits = [
            np.median(np.arctan(pixels_to_rays(lens, edge)[:, across]))
            for edge in (silhouette.first, silhouette.second)
        ]
        half_angles.append((limits[1] - limits[0]) / 2)
    return float(scene.standoff_m * np.sin(np.median(half_angles))) if half_angles else float("nan")


def _edges(found: dict[int, Silhouette], lens: Lens, travel: TravelDirection) -> PlumbEdges:
    """All edge points with the cable along x, relative to the principal point."""
    points, frame, side = [], [], []
    for k, silhouette in found.items():
        for sign, edge in ((-1, silhouette.first), (1, silhouette.second)):
            points.append(edge - lens.principal_point_px)
            frame.append(np.full(len(edge), k))
            side.append(np.full(len(edge), sign))
    stacked = np.concatenate(points)
    upright = travel in (TravelDirection.UP, TravelDirection.DOWN)
    return PlumbEdges(
        points_px=stacked[:, ::-1] if upright else stacked,
        frame=np.concatenate(frame).astype(np.int64),
        side=np.concatenate(side).astype(np.int64),
    )


def _scene(frames: FrameSequence, lens: Lens, travel: TravelDirection, scene: CableScene) -> PlumbScene:
    return PlumbScene(
        half_diagonal_px=float(np.hypot(lens.width_px, lens.height_px) / 2),
        focal_px=lens.focal_px,
        standoff_m=scene.standoff_m,
        positions_m=frames.places_m(scene.travel_m),
        forward=1 if travel in (TravelDirection.RIGHT, TravelDirection.DOWN) else -1,
    )
