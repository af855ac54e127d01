"""Stage *joint*: all cameras adjusted together as one rig moving along the cable.

Takes the blocks as they were adjusted alone, marks that neighbouring blocks share, and what is known of
robot and lenses; gives the blocks again, now in one frame, with their lenses refined and one covariance.
What is depth for one camera is width for its neighbour, so the ring sees the focal lengths that a single
strip cannot; and a body rotation that moves one camera forwards moves its opposite backwards, so the ring
keeps the scale.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.cable.adjust import Orientation, intersect_block, rms
from pipeline.cable.closing import SharedMarks
from pipeline.cable.joint_path import RingPath, ring_path
from pipeline.cable.joint_rig import (
    JointBlock,
    JointOptions,
    camera_poses,
    gather,
    nominal_rig,
    rig_priors,
    started,
)
from pipeline.cable.joint_sections import RingSigmas, ring_sigmas
from pipeline.cable.joint_sigmas import block_covariance, diameter_sigmas, refined_lens
from pipeline.cable.joint_surface import SurfaceEffect, prior_for, tie_point_diameters
from pipeline.cable.joint_weights import weighed
from pipeline.cable.pos import RobotPriors
from pipeline.core.bundle import BundleOptions, BundleResult, RigPriors, adjust_bundle
from pipeline.core.events import Emit, Event
from pipeline.core.parallel import each_side_by_side
from pipeline.core.rig import Observations, Rig
from pipeline.core.smooth_surface import SurfacePrior
from pipeline.core.vocabulary import Array

__all__ = ["JointBlock", "JointOptions", "RingOrientation", "adjust_ring", "orient_ring"]

LENS_POINTS = 500
"""So many tie points of each block tell the lenses to a part in a thousand."""

SURFACE_TOLERANCE = 1e-8
"""The adjustment with the surface prior stops when a step lowers the cost by less than this share."""


@dataclass(frozen=True, kw_only=True)
class RingOrientation:
    """The adjusted ring.

    Attributes:
        blocks: each block's orientation, all in one frame.
        covariance: (7 b, 7 b) of each block as a whole: rotation vector (rad), shift (m), scale.
        section_y_m: (n,) places along the cable, and for each
        diameter_sigma_mm: (n,) standard deviation of the circle through all tie points there from
            orientations and lenses, travel taken as exact;
        lens_sigma_mm: (n,) the lenses' share of it.
        strips: the same for each block's strip of surface: what a measured section's sigma is made of.
        shared_marks: marks that two blocks share.
        shared_residual_px: root mean square residual of the shared marks.
        readout_mm, readout_sigma_mm: way that the robot travels while a frame's rows are read (rolling
            shutter), and its standard deviation; sigma 0: taken as given.
        path: the robot's way, and the size of its ring; None in runs of earlier versions.
        iterations: steps of the last adjustment.
        surface_effect: what the surface prior changes; None where it was not asked for.
    """

    blocks: tuple[Orientation, ...]
    covariance: Array
    section_y_m: Array
    diameter_sigma_mm: Array
    lens_sigma_mm: Array
    strips: RingSigmas
    shared_marks: int
    shared_residual_px: float
    readout_mm: float = 0.0
    readout_sigma_mm: float = 0.0
    path: RingPath | None = None
    iterations: int
    surface_effect: SurfaceEffect | None


def adjust_ring(
    blocks: tuple[JointBlock, ...],
    shared: SharedMarks,
    robot: RobotPriors,
    options: JointOptions,
    emit: Emit,
    stations: tuple[tuple[str, float], ...] = (),
) -> RingOrientation:
    """Adjust all blocks together.

    Args:
        blocks: adjusted alone, over the same frames.
        shared: marks seen by two blocks.
        robot: priors.
        options: see there.
        emit: progress, one event an iteration.
        stations: names and places (m) where the report shows what the surface prior changes.
    """
    rig, priors, measured = _prepared(blocks, shared, robot, options)
    compared = options.surface_sigma_mm > 0
    passes = len(options.loss_scales_px) + compared

    def adjusted(number: int, rig: Rig, scale: float, surface: SurfacePrior | None) -> BundleResult:
        def tell(iteration: int, iterations: int) -> None:
            emit(Event(stage="joint", done=number * iterations + iteration - 1, total=iterations * passes))

        # the prior weighs so little that a step worth having hardly lowers the cost
        tolerance = BundleOptions.tolerance if surface is None else SURFACE_TOLERANCE
        bundle = BundleOptions(sigma_px=options.sigma_px, loss_scale_px=scale, tolerance=tolerance)
        return adjust_bundle(rig, measured, priors, bundle, tell, surface)

    for number, scale in enumerate(options.loss_scales_px):
        result = adjusted(number, rig, scale, None)
        rig = result.rig
        if number < len(options.loss_scales_px) - 1:
            tied = len(measured) - len(shared.pixels)
            measured = weighed(measured, result, tied, options.sigma_px, options.least_sigma_px)
    found = _ring(blocks, result, measured, shared, robot, options)
    if not compared:
        return found
    surface = prior_for(result, options.surface_sigma_mm, options.surface_patch_mm)
    held = adjusted(passes - 1, rig, options.loss_scales_px[-1], surface)
    other = _ring(blocks, held, measured, shared, robot, options)
    effect = _effect(found, other, stations, options)
    return replace(other if options.surface_used else found, surface_effect=effect)


def orient_ring(
    blocks: tuple[JointBlock, ...],
    shared: SharedMarks,
    robot: RobotPriors,
    options: JointOptions,
    emit: Emit,
) -> tuple[Orientation, ...]:
    """The blocks as a first, loose adjustment of the ring orients them, with lenses that pictures can be
    unrolled through.

    Arguments as of :func:`adjust_ring`.
    """
    few = replace(options, points_per_block=min(options.points_per_block, LENS_POINTS))
    rig, priors, measured = _prepared(blocks, shared, robot, few)
    bundle = BundleOptions(sigma_px=options.sigma_px, loss_scale_px=options.loss_scales_px[0])

    def tell(iteration: int, iterations: int) -> None:
        emit(Event(stage="joint", done=iteration - 1, total=iterations))

    result = adjust_bundle(rig, measured, priors, bundle, tell, None)

    return _blocks(blocks, result, options.gross_px)


def _prepared(
    blocks: tuple[JointBlock, ...], shared: SharedMarks, robot: RobotPriors, options: JointOptions
) -> tuple[Rig, RigPriors, Observations]:
    """Where the adjustment begins, what is known, and what was measured."""
    nominal = nominal_rig(blocks, robot)
    measured, points = gather(blocks, shared, options)
    rig = replace(started(nominal, blocks), points=points)
    return rig, rig_priors(nominal, blocks, robot, options), measured


def _ring(
    blocks: tuple[JointBlock, ...],
    result: BundleResult,
    measured: Observations,
    shared: SharedMarks,
    robot: RobotPriors,
    options: JointOptions,
) -> RingOrientation:
    """What an adjustment found, block by block."""
    ties = np.arange(len(measured)) < len(measured) - len(shared.pixels)
    residual = _in_pixels(measured, result)[~ties]
    section_y, total, lens_part = diameter_sigmas(result, len(blocks), robot.y_m)

    return RingOrientation(
        blocks=_blocks(blocks, result, options.gross_px),
        covariance=block_covariance(result, len(blocks)),
        section_y_m=section_y,
        diameter_sigma_mm=total,
        lens_sigma_mm=lens_part,
        strips=ring_sigmas(
            result, measured.subset(ties), np.array([b.azimuth_deg for b in blocks]), robot.y_m
        ),
        shared_marks=len(shared.points),
        shared_residual_px=float(np.sqrt(np.nanmean(np.sum(residual**2, axis=1)))) if len(residual) else 0.0,
        readout_mm=1000 * result.rig.readout_m,
        readout_sigma_mm=1000 * float(np.sqrt(result.covariance[-1, -1])),
        path=ring_path(result),
        iterations=result.iterations,
        surface_effect=None,
    )


def _in_pixels(measured: Observations, result: BundleResult) -> Array:
    """Residuals (n, 2) as they were before each was divided by its looseness."""
    if measured.looseness is None:
        return result.residuals
    return result.residuals * measured.looseness.reshape(len(measured), -1)


def _effect(
    without: RingOrientation,
    tied: RingOrientation,
    stations: tuple[tuple[str, float], ...],
    options: JointOptions,
) -> SurfaceEffect:
    places = np.array([position for _, position in stations])

    def diameters(ring: RingOrientation) -> Array:
        return tie_point_diameters(np.concatenate([b.points for b in ring.blocks]), places)

    def sigmas(ring: RingOrientation) -> Array:
        return np.interp(places, ring.section_y_m, ring.diameter_sigma_mm)

    return SurfaceEffect(
        sigma_mm=options.surface_sigma_mm,
        used=options.surface_used,
        names=tuple(name for name, _ in stations),
        without_mm=diameters(without),
        with_mm=diameters(tied),
        without_sigma_mm=sigmas(without),
        with_sigma_mm=sigmas(tied),
    )


def _blocks(blocks: tuple[JointBlock, ...], result: BundleResult, gross_px: float) -> tuple[Orientation, ...]:
    def block(number: int) -> Orientation:
        return _block(number, blocks[number], result, gross_px)

    return tuple(each_side_by_side(block, range(len(blocks))))


def _block(number: int, block: JointBlock, result: BundleResult, gross_px: float) -> Orientation:
    """A block's orientation in the ring, all its tie points intersected anew."""
    alone, poses = block.orientation, camera_poses(result.rig, number)
    lens = refined_lens(number, alone.lens, result)
    seen = Observations(
        frame=alone.frame, camera=np.zeros_like(alone.frame), point=alone.point, pixels=alone.pixels
    )
    accepted, points, residuals = intersect_block(poses, lens, alone.points, seen, gross_px)
    keypoints = np.bincount(accepted.frame, minlength=len(poses))
    return replace(
        alone,
        lens=lens,
        poses=poses,
        points=points,
        frame=accepted.frame,
        point=accepted.point,
        pixels=accepted.pixels,
        residuals=residuals,
        keypoints=keypoints,
        reprojection_px=rms(residuals),
        datum_origin=np.array([0.0, poses.centres[:, 1].mean(), 0.0]),
    )
