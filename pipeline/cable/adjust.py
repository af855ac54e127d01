"""Stage *adjust*: POS-aided aerial triangulation of one block (paper, section 3.2).

Takes tie points, the lens and the POS; gives adjusted orientations and points, Table 1's figures, and how
well the POS holds the block in place (its datum).  The POS enters as observed unknowns with their
covariance, never as hard values; the lens is held.  What the lens correction is worth is measured here too,
by adjusting once without it.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust_records import AdjustOptions, LensEffect, Orientation
from pipeline.cable.match import TiePoints
from pipeline.core.bundle import BundleOptions, BundleResult, RigPriors, adjust_bundle, intersect_points
from pipeline.core.division import unknowns, with_unknowns
from pipeline.core.events import Emit, Event, part
from pipeline.core.rig import Observations, Rig, moments
from pipeline.core.rotations import cross_matrix, poses_from_centres
from pipeline.core.vocabulary import Array, Lens, Poses, PosPriors

__all__ = [
    "AdjustOptions",
    "LensEffect",
    "Orientation",
    "adjust_block",
    "choose_points",
    "intersect_block",
    "rms",
]


def adjust_block(
    block: str, tie_points: TiePoints, lens: Lens, pos: PosPriors, options: AdjustOptions, emit: Emit
) -> Orientation:
    """Adjust one block.

    Args:
        block: its name, for progress.
        tie_points: measurements in original frames.
        lens: held as given.
        pos: observed orientations.
        options: see there.
        emit: progress, one event an iteration.
    """
    measured = Observations(
        frame=tie_points.frame,
        camera=np.zeros_like(tie_points.frame),
        point=tie_points.point,
        pixels=tie_points.pixels,
    )
    main, extra = part(emit, 0.0, 0.75), part(emit, 0.75, 1.0)
    few, starts = _few(measured, tie_points.starts, options.points)
    few, result = _adjust(block, few, starts, lens, pos, options, main)
    poses = poses_from_centres(result.rig.body_rotations, result.rig.body_centres)
    accepted, points, residuals = intersect_block(poses, lens, tie_points.starts, measured, options.gross_px)
    keypoints = np.bincount(accepted.frame, minlength=len(poses))
    origin = np.array([0.0, poses.centres[:, 1].mean(), 0.0])
    return Orientation(
        lens=lens,
        poses=poses,
        points=points,
        frame=accepted.frame,
        point=accepted.point,
        pixels=accepted.pixels,
        residuals=residuals,
        keypoints=keypoints,
        calibrated=keypoints >= options.least_keypoints,
        reprojection_px=rms(residuals),
        datum_origin=origin,
        datum_information=_datum(poses, pos, origin, options),
        lens_effect=_without_correction(block, few, result.rig.points, lens, pos, options, extra),
    )


def choose_points(point: NDArray[np.int64], places: Array, most: int) -> NDArray[np.int64]:
    """The points seen most often in each centimetre of cable, about ``most`` in all, in ascending order.

    Args:
        point: (n,) the point of each measurement.
        places: (m, 3) rough places of the points, metres.
        most: number wanted.
    """
    views = np.bincount(point, minlength=len(places))
    usable = np.flatnonzero(views >= 3)
    stretch = np.floor(places[usable, 1] / 0.01)
    order = np.lexsort((-views[usable], stretch))
    first = np.flatnonzero(np.diff(stretch[order], prepend=-np.inf))
    rank = np.arange(len(order)) - np.repeat(first, np.diff(np.append(first, len(order))))
    return np.sort(usable[order[rank < max(most // max(len(first), 1), 1)]])


def intersect_block(
    poses: Poses, lens: Lens, starts: Array, measured: Observations, gross_px: float
) -> tuple[Observations, Array, Array]:
    """Intersect all tie points of a block with its orientations held, leaving out gross errors.

    Returns:
        The accepted measurements, the points (m, 3), and the residuals (n, 2) of the accepted.
    """
    rig = _single_camera(poses, lens, starts)
    if poses.readout_m:
        measured = replace(measured, moment=moments(measured.pixels[:, 1], lens.height_px))
    for _ in range(2):
        placed, residuals = intersect_points(rig, measured)
        good = np.linalg.norm(residuals, axis=1) < gross_px
        if good.all():
            break
        measured = _seen_twice(measured.subset(good))
    placed, residuals = intersect_points(placed, measured, gross_errors=False)
    return measured, placed.points, residuals


def _few(measured: Observations, starts: Array, most: int) -> tuple[Observations, Array]:
    """The measurements of the points that orient the block, numbered anew, and their rough places."""
    chosen = choose_points(measured.point, starts, most)
    number = np.full(len(starts), -1)
    number[chosen] = np.arange(len(chosen))
    few = measured.subset(number[measured.point] >= 0)
    return replace(few, point=number[few.point]), starts[chosen]


def _adjust(
    block: str,
    measured: Observations,
    starts: Array,
    lens: Lens,
    pos: PosPriors,
    options: AdjustOptions,
    emit: Emit,
) -> tuple[Observations, BundleResult]:
    """Loose to tight, leaving out gross errors after the first pass."""
    rig = _single_camera(pos.poses, lens, starts)
    priors = RigPriors(
        reference=rig, body_sigmas=pos.sigmas, mount_sigmas=np.zeros((1, 6)), lens_sigmas=np.zeros((1, 4))
    )
    for number, scale in enumerate(options.loss_scales_px):

        def tell(iteration: int, iterations: int, number: int = number) -> None:
            total = iterations * len(options.loss_scales_px)
            emit(Event(stage="adjust", block=block, done=number * iterations + iteration - 1, total=total))

        bundle = BundleOptions(sigma_px=options.sigma_px, loss_scale_px=scale)
        result = adjust_bundle(rig, measured, priors, bundle, tell)
        rig = result.rig
        keep = np.linalg.norm(result.residuals, axis=1) < max(options.gross_px, scale)
        if number < len(options.loss_scales_px) - 1:
            measured = _seen_twice(measured.subset(keep))
    return measured, result


def _seen_twice(measured: Observations) -> Observations:
    """Without the points that are left with a single measurement: they have no depth."""
    views = np.bincount(measured.point)
    return measured.subset(views[measured.point] >= 2)


def _single_camera(poses: Poses, lens: Lens, points: Array) -> Rig:
    """A rig whose body is the camera itself."""
    return Rig(
        body_rotations=poses.rotations,
        body_centres=poses.centres,
        mount_rotations=np.eye(3)[None],
        mount_centres=np.zeros((1, 3)),
        lenses=unknowns(lens)[None],
        points=points,
        readout_m=poses.readout_m,
    )


def _without_correction(
    block: str,
    measured: Observations,
    points: Array,
    lens: Lens,
    pos: PosPriors,
    options: AdjustOptions,
    emit: Emit,
) -> LensEffect | None:
    straight = with_unknowns(lens, unknowns(lens) * np.array([1, 1, 1, 0]))
    if lens.division_lambda == 0:
        return None
    loose = replace(options, loss_scales_px=(8.0,), gross_px=np.inf)
    _, result = _adjust(block, measured, points, straight, pos, loose, emit)
    return LensEffect(points_uncorrected=result.rig.points, reprojection_px=rms(result.residuals))


def _datum(poses: Poses, pos: PosPriors, origin: Array, options: AdjustOptions) -> Array:
    """Information of the POS on a similarity of the whole block.

    A similarity X' = o + (1 + s) exp([w]x)(X - o) + t turns a camera by -R w about its own axes and moves its
    centre by w x (C - o) + t + s (C - o).
    """
    arms = poses.centres - origin
    count = len(poses)
    derivative = np.zeros((count, 6, 7))
    derivative[:, :3, :3] = -poses.rotations
    derivative[:, 3:, :3] = -cross_matrix(arms)
    derivative[:, 3:, 3:6] = np.eye(3)
    derivative[:, 3:, 6] = arms
    whitened = (derivative / pos.sigmas[:, :, None]).reshape(-1, 7)
    travel_m = float(np.ptp(poses.centres[:, 1]))
    independent = min(count, 1 + travel_m / options.correlation_m)
    return whitened.T @ whitened * (independent / count)


def rms(residuals: Array) -> float:
    """Root mean square length of residuals (n, 2)."""
    return float(np.sqrt(np.nanmean(np.sum(residuals**2, axis=1))))
