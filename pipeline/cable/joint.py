"""Stage *joint*: all cameras adjusted together as one rig moving along the cable.

Takes the blocks as they were adjusted alone, marks that neighbouring blocks share, and what is known of
robot and lenses; gives the blocks again, now in one frame, with their lenses refined and one covariance.
What is depth for one camera is width for its neighbour, so the ring sees the focal lengths that a single
strip cannot; and a body rotation that moves one camera forwards moves its opposite backwards, so the ring
keeps the scale.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.cable.adjust import Orientation, choose_points, intersect_block, rms
from pipeline.cable.closing import SharedMarks
from pipeline.cable.pos import RobotPriors
from pipeline.core.bundle import BundleOptions, BundleResult, RigPriors, adjust_bundle
from pipeline.core.division import coefficient, parameters, with_parameters
from pipeline.core.events import Emit, Event
from pipeline.core.normals import gradient_through_points
from pipeline.core.rig import LENS_PARAMETERS, POSE_PARAMETERS, Observations, Rig
from pipeline.core.rotations import (
    cross_matrix,
    nominal_cam_from_world,
    poses_from_centres,
    rotation_from_vector,
    vector_from_rotation,
)
from pipeline.core.vocabulary import Array, Lens, Poses, TravelDirection

SECTION_STEP_M = 0.02
"""Distance of the sections whose standard deviation is carried through, and their half width."""


@dataclass(frozen=True, kw_only=True)
class JointOptions:
    """How the ring is adjusted.

    Attributes:
        together: false leaves the blocks as they were adjusted alone, as in the paper.
        sigma_px: standard deviation of an image measurement.
        shared_sigma_px: of a mark matched between two blocks; all its measurements share the matching's
            error.
        loss_scales_px: Cauchy scales of the successive adjustments, loose to tight.
        gross_px: measurements further off than this are left out in the end.
        points_per_block: so many tie points of each block take part, those seen most often.
        principal_point_share: standard deviation of an uncalibrated principal point, as a share of the width.
    """

    together: bool = True
    sigma_px: float = field(default=0.1, metadata={"above": 0.0})
    shared_sigma_px: float = field(default=0.6, metadata={"above": 0.0})
    loss_scales_px: tuple[float, ...] = field(default=(20.0, 1.0), metadata={"above": 0.0})
    gross_px: float = field(default=1.5, metadata={"above": 0.0})
    points_per_block: int = field(default=2500, metadata={"minimum": 50})
    principal_point_share: float = field(default=0.01, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class JointBlock:
    """What the joint adjustment needs to know of one block."""

    name: str
    azimuth_deg: float
    travel_in_image: TravelDirection
    orientation: Orientation


@dataclass(frozen=True, kw_only=True)
class RingOrientation:
    """The adjusted ring.

    Attributes:
        blocks: each block's orientation, all in one frame.
        covariance: (7 b, 7 b) of each block as a whole: rotation vector (rad), shift (m), scale.
        section_y_m: (n,) places along the cable, and for each
        diameter_sigma_mm: (n,) standard deviation of a diameter there from orientations and lenses, travel
            taken as exact;
        lens_sigma_mm: (n,) the lenses' share of it.
        shared_marks: marks that two blocks share.
        shared_residual_px: root mean square residual of the shared marks.
        iterations: steps of the last adjustment.
    """

    blocks: tuple[Orientation, ...]
    covariance: Array
    section_y_m: Array
    diameter_sigma_mm: Array
    lens_sigma_mm: Array
    shared_marks: int
    shared_residual_px: float
    iterations: int


def adjust_ring(
    blocks: tuple[JointBlock, ...],
    shared: SharedMarks,
    robot: RobotPriors,
    options: JointOptions,
    emit: Emit,
) -> RingOrientation:
    """Adjust all blocks together.

    Args:
        blocks: adjusted alone, over the same frames.
        shared: marks seen by two blocks.
        robot: priors.
        options: see there.
        emit: progress, one event an iteration.
    """
    nominal = _nominal_rig(blocks, robot)
    priors = _priors(nominal, blocks, robot, options)
    measured, points = _gather(blocks, shared, options)
    rig = replace(_started(nominal, blocks), points=points)
    for number, scale in enumerate(options.loss_scales_px):

        def tell(iteration: int, iterations: int, number: int = number) -> None:
            total = iterations * len(options.loss_scales_px)
            emit(Event(stage="joint", done=number * iterations + iteration - 1, total=total))

        bundle = BundleOptions(sigma_px=options.sigma_px, loss_scale_px=scale)
        result = adjust_bundle(rig, measured, priors, bundle, tell)
        rig = result.rig
    residual = (
        result.residuals[len(measured) - len(shared.pixels) :] * options.shared_sigma_px / options.sigma_px
    )
    section_y, total, lens_part = _diameter_sigmas(result, len(blocks), robot.y_m)
    return RingOrientation(
        blocks=tuple(_block(n, b, result, options.gross_px) for n, b in enumerate(blocks)),
        covariance=_block_covariance(result, len(blocks)),
        section_y_m=section_y,
        diameter_sigma_mm=total,
        lens_sigma_mm=lens_part,
        shared_marks=len(shared.points),
        shared_residual_px=float(np.sqrt(np.nanmean(np.sum(residual**2, axis=1)))) if len(residual) else 0.0,
        iterations=result.iterations,
    )


def _nominal_rig(blocks: tuple[JointBlock, ...], robot: RobotPriors) -> Rig:
    """The robot as it was built, gliding evenly along the axis."""
    frames = len(robot.y_m)
    radians = np.deg2rad([b.azimuth_deg for b in blocks])
    return Rig(
        body_rotations=np.tile(np.eye(3), (frames, 1, 1)),
        body_centres=np.stack([np.zeros(frames), robot.y_m, np.zeros(frames)], axis=1),
        mount_rotations=np.stack([nominal_cam_from_world(b.azimuth_deg, b.travel_in_image) for b in blocks]),
        mount_centres=robot.standoff_m * np.stack([np.cos(radians), 0 * radians, -np.sin(radians)], axis=1),
        lenses=np.stack([parameters(b.orientation.lens) for b in blocks]),
        points=np.zeros((0, 3)),
    )


def _started(nominal: Rig, blocks: tuple[JointBlock, ...]) -> Rig:
    """Body poses from the blocks as they were adjusted alone: their mean, block by block turned back."""
    turns, centres = [], []
    for number, block in enumerate(blocks):
        mount, arm = nominal.mount_rotations[number], nominal.mount_centres[number]
        rotations = mount.T @ block.orientation.poses.rotations
        turns.append(vector_from_rotation(rotations))
        centres.append(block.orientation.poses.centres - np.einsum("nji,j->ni", rotations, arm))
    return replace(
        nominal,
        body_rotations=rotation_from_vector(np.mean(turns, axis=0)),
        body_centres=np.mean(centres, axis=0),
    )


def _priors(
    nominal: Rig, blocks: tuple[JointBlock, ...], robot: RobotPriors, options: JointOptions
) -> RigPriors:
    lenses = []
    for block in blocks:
        lens = block.orientation.lens
        per_lambda = coefficient(replace(lens, division_lambda=1.0))
        centre = 0.0 if lens.focal_sigma_px == 0 else options.principal_point_share * lens.width_px
        lenses.append([lens.focal_sigma_px, centre, centre, per_lambda * lens.lambda_sigma])
    return RigPriors(
        reference=nominal,
        body_sigmas=robot.body_sigmas,
        mount_sigmas=np.tile(robot.mount_sigmas, (len(blocks), 1)),
        lens_sigmas=np.array(lenses),
    )


def _gather(
    blocks: tuple[JointBlock, ...], shared: SharedMarks, options: JointOptions
) -> tuple[Observations, Array]:
    """Chosen measurements of all blocks, then the shared marks; points numbered along the cable."""
    frames, cameras, points, pixels, places, count = [], [], [], [], [], 0
    for number, block in enumerate(blocks):
        orientation = block.orientation
        chosen = choose_points(orientation.point, orientation.points, options.points_per_block)
        new = np.full(len(orientation.points), -1)
        new[chosen] = count + np.arange(len(chosen))
        rows = new[orientation.point] >= 0
        frames.append(orientation.frame[rows])
        cameras.append(np.full(rows.sum(), number))
        points.append(new[orientation.point[rows]])
        pixels.append(orientation.pixels[rows])
        places.append(orientation.points[chosen])
        count += len(chosen)
    tied = sum(len(p) for p in points)
    looseness = np.ones(tied + len(shared.pixels))
    looseness[tied:] = options.shared_sigma_px / options.sigma_px
    place = np.concatenate([*places, shared.points])
    order = np.argsort(place[:, 1], kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    measured = Observations(
        frame=np.concatenate([*frames, shared.frame]),
        camera=np.concatenate([*cameras, shared.block]),
        point=rank[np.concatenate([*points, count + shared.mark])],
        pixels=np.concatenate([*pixels, shared.pixels]),
        looseness=looseness,
    )
    return measured, place[order]


def _camera_poses(rig: Rig, camera: int) -> Poses:
    rotations = rig.mount_rotations[camera] @ rig.body_rotations
    arms = np.einsum("nji,j->ni", rig.body_rotations, rig.mount_centres[camera])
    return poses_from_centres(rotations, rig.body_centres + arms)


def _block(number: int, block: JointBlock, result: BundleResult, gross_px: float) -> Orientation:
    """A block's orientation in the ring, all its tie points intersected anew."""
    alone, poses = block.orientation, _camera_poses(result.rig, number)
    lens = _refined_lens(number, alone.lens, result)
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


def _block_covariance(result: BundleResult, blocks: int) -> Array:
    """Covariance of each block as a whole: the similarity that its cameras' joint errors amount to."""
    rig = result.rig
    frames = len(rig.body_rotations)
    maps = []
    for camera in range(blocks):
        poses = _camera_poses(rig, camera)
        by_unknowns = np.zeros((frames, 6, rig.unknowns))
        mount = slice(POSE_PARAMETERS * (frames + camera), POSE_PARAMETERS * (frames + camera + 1))
        back = rig.body_rotations.transpose(0, 2, 1)
        for k in range(frames):
            body = slice(POSE_PARAMETERS * k, POSE_PARAMETERS * (k + 1))
            by_unknowns[k, :3, body][:, :3] = rig.mount_rotations[camera]
            by_unknowns[k, 3:, body][:, :3] = back[k] @ cross_matrix(rig.mount_centres[camera])
            by_unknowns[k, 3:, body][:, 3:] = np.eye(3)
            by_unknowns[k, :3, mount][:, :3] = np.eye(3)
            by_unknowns[k, 3:, mount][:, 3:] = back[k]
        arms = poses.centres - np.array([0.0, poses.centres[:, 1].mean(), 0.0])
        by_whole = np.zeros((frames, 6, 7))
        by_whole[:, :3, :3] = -poses.rotations
        by_whole[:, 3:, :3] = -cross_matrix(arms)
        by_whole[:, 3:, 3:6] = np.eye(3)
        by_whole[:, 3:, 6] = arms
        inverse = np.linalg.pinv(by_whole.reshape(-1, 7))
        maps.append(inverse @ by_unknowns.reshape(-1, rig.unknowns))
    whole = np.concatenate(maps)
    return whole @ result.covariance @ whole.T


def _refined_lens(number: int, stated: Lens, result: BundleResult) -> Lens:
    """The block's lens as adjusted, with its standard deviations."""
    if stated.focal_sigma_px == stated.lambda_sigma == 0:
        return stated  # held: it comes back to the last digit
    rig = result.rig
    lens = with_parameters(stated, rig.lenses[number])
    first = POSE_PARAMETERS * (len(rig.body_rotations) + len(rig.lenses)) + LENS_PARAMETERS * number
    sigmas = np.sqrt(np.diag(result.covariance)[first : first + LENS_PARAMETERS])
    per_lambda = coefficient(replace(lens, division_lambda=1.0))
    return replace(lens, focal_sigma_px=float(sigmas[0]), lambda_sigma=float(sigmas[3] / per_lambda))


def _diameter_sigmas(result: BundleResult, blocks: int, y_m: Array) -> tuple[Array, Array, Array]:
    """Places along the cable, the diameter's standard deviation there (mm), and the lenses' share of it.

    A section is the circle through the tie points around it; they follow the orientations along their rays.
    The lenses' share is what would go if they were known: total variance less that with the lenses given.
    """
    points = result.rig.points
    places = np.arange(y_m.min(), y_m.max() + 1e-9, SECTION_STEP_M)
    gains = np.zeros((len(places), len(points), 3))
    for number, place in enumerate(places):
        near = np.flatnonzero(np.abs(points[:, 1] - place) < SECTION_STEP_M)
        centre = np.median(points[near], axis=0)
        away = points[near] - centre
        out = away * [1, 0, 1] / np.hypot(away[:, 0], away[:, 2])[:, None]
        design = np.column_stack([np.ones(len(near)), out[:, 0], out[:, 2]])
        gains[number, near] = 2 * np.linalg.pinv(design)[0][:, None] * out
    gradient = 1000 * gradient_through_points(result.normals, gains)
    total = np.einsum("nu,uv,nv->n", gradient, result.covariance, gradient)
    free = POSE_PARAMETERS * (len(result.rig.body_rotations) + blocks)
    lens = free + np.flatnonzero(np.diag(result.covariance)[free:] > 0)
    if not len(lens):
        return places, np.sqrt(total), np.zeros_like(total)
    towards = gradient @ result.covariance[:, lens]
    share = np.einsum("nl,lk,nk->n", towards, np.linalg.inv(result.covariance[np.ix_(lens, lens)]), towards)
    return places, np.sqrt(total), np.sqrt(np.minimum(share, total))
