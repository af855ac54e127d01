"""What the joint adjustment starts from: the robot as one rig, what is known of it, and what was measured.

Takes the blocks as they were adjusted alone and the marks they share; gives the rig, its priors and its
observations.  Leaves out the adjusting.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.cable.adjust import Orientation, choose_points
from pipeline.cable.closing import SharedMarks
from pipeline.cable.pos import RobotPriors
from pipeline.core.bundle import RigPriors
from pipeline.core.division import bend_per_lambda, unknowns
from pipeline.core.rig import Observations, Rig, moments
from pipeline.core.rotations import (
    nominal_cam_from_world,
    poses_from_centres,
    rotation_from_vector,
    vector_from_rotation,
)
from pipeline.core.vocabulary import Array, Poses, TravelDirection


@dataclass(frozen=True, kw_only=True)
class JointOptions:
    """How the ring is adjusted.

    Attributes:
        together: false leaves the blocks as they were adjusted alone, as in the paper.
        sigma_px: standard deviation of an image measurement, until the residuals tell a better one.
        least_sigma_px: the least that residuals may make of either.
        shared_sigma_px: of a mark matched between two blocks, whose measurements all share the matching's
            error, until the residuals tell a better one.
        loss_scales_px: Cauchy scales of the successive adjustments, loose to tight.
        gross_px: measurements further off than this are left out in the end.
        points_per_block: so many tie points of each block take part, those seen most often.
        principal_point_share: standard deviation of an uncalibrated principal point, as a share of the width.
        readout_sigma_mm: how far the robot may travel while a frame's rows are read one after the other
            (rolling shutter), as a standard deviation; 0: all rows are exposed at once (global shutter).
        surface_sigma_mm: adjust once more with the weak prior that the surface is locally smooth, from which
            it departs by so much; 0: do not.  The report shows the diameters without and with it.
        surface_patch_mm: side of the patches over which these departures are alike.
        surface_used: true makes the result with the prior that of the run.
    """

    together: bool = True
    sigma_px: float = field(default=0.1, metadata={"above": 0.0})
    least_sigma_px: float = field(default=0.05, metadata={"above": 0.0})
    shared_sigma_px: float = field(default=0.6, metadata={"above": 0.0})
    loss_scales_px: tuple[float, ...] = field(default=(20.0, 1.0), metadata={"above": 0.0})
    gross_px: float = field(default=1.5, metadata={"above": 0.0})
    points_per_block: int = field(default=2500, metadata={"minimum": 50})
    principal_point_share: float = field(default=0.01, metadata={"minimum": 0.0})
    readout_sigma_mm: float = field(default=5.0, metadata={"minimum": 0.0})
    surface_sigma_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    surface_patch_mm: float = field(default=20.0, metadata={"above": 0.0})
    surface_used: bool = False


@dataclass(frozen=True, kw_only=True)
class JointBlock:
    """What the joint adjustment needs to know of one block."""

    name: str
    azimuth_deg: float
    travel_in_image: TravelDirection
    orientation: Orientation


def nominal_rig(blocks: tuple[JointBlock, ...], robot: RobotPriors) -> Rig:
    """The robot as it was built, gliding evenly along the axis."""
    frames = len(robot.y_m)
    radians = np.deg2rad([b.azimuth_deg for b in blocks])
    return Rig(
        body_rotations=np.tile(np.eye(3), (frames, 1, 1)),
        body_centres=np.stack([np.zeros(frames), robot.y_m, np.zeros(frames)], axis=1),
        mount_rotations=np.stack([nominal_cam_from_world(b.azimuth_deg, b.travel_in_image) for b in blocks]),
        mount_centres=robot.standoff_m * np.stack([np.cos(radians), 0 * radians, -np.sin(radians)], axis=1),
        lenses=np.stack([unknowns(b.orientation.lens) for b in blocks]),
        points=np.zeros((0, 3)),
    )


def started(nominal: Rig, blocks: tuple[JointBlock, ...]) -> Rig:
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


def rig_priors(
    nominal: Rig, blocks: tuple[JointBlock, ...], robot: RobotPriors, options: JointOptions
) -> RigPriors:
    """What is known of robot, mountings and lenses."""
    lenses = []
    for block in blocks:
        lens = block.orientation.lens
        per_lambda = bend_per_lambda(lens)
        centre = 0.0 if lens.focal_sigma_px == 0 else options.principal_point_share * lens.width_px
        lenses.append([lens.focal_sigma_px, centre, centre, per_lambda * lens.lambda_sigma])
    return RigPriors(
        reference=nominal,
        body_sigmas=robot.body_sigmas,
        mount_sigmas=np.tile(robot.mount_sigmas, (len(blocks), 1)),
        lens_sigmas=np.array(lenses),
        readout_sigma_m=options.readout_sigma_mm / 1000,
    )


def gather(
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
    heights_px = np.array([b.orientation.lens.height_px for b in blocks])
    moment = moments(measured.pixels[:, 1], heights_px[measured.camera])
    return replace(measured, moment=moment), place[order]


def camera_poses(rig: Rig, camera: int) -> Poses:
    """One camera's poses, cam_from_world."""
    rotations = rig.mount_rotations[camera] @ rig.body_rotations
    arms = np.einsum("nji,j->ni", rig.body_rotations, rig.mount_centres[camera])
    return replace(poses_from_centres(rotations, rig.body_centres + arms), readout_m=rig.readout_m)
