"""Stage *pos*: what is known of each frame's place and attitude before any image is looked at.

Takes a block and its frames; gives :class:`~pipeline.core.vocabulary.PosPriors`: constructed from the known
travel (paper, section 3.1) or read from a POS file (``pos_file.py``).  Leaves out the images.
"""

from dataclasses import dataclass, field
from math import cos, radians, sin, sqrt

import numpy as np

from pipeline.cable.pos_file import read_pos, write_pos
from pipeline.cable.survey_records import Block, Cable, Robot, Survey
from pipeline.core.rotations import nominal_pose
from pipeline.core.vocabulary import Array, FrameSequence, PosPriors

LOOSE = 3.0
"""How much looser than its own wander a frame's place along the cable is held in the joint adjustment."""

END_SIGMA_M = 2e-6
"""How tightly the ends of the travel are held there: what the travel's own error adds is told apart."""

__all__ = [
    "PosOptions",
    "RobotPriors",
    "construct_pos",
    "pos_of_block",
    "read_pos",
    "robot_priors",
    "travel_share_sigma",
    "write_pos",
]


@dataclass(frozen=True, kw_only=True)
class PosOptions:
    """How well the POS is known: standard deviations.

    Attributes:
        sway_deg: attitude of the robot about any axis.
        sway_mm: position of the robot across the cable.
        wander_mm: place along the cable half way, as the speed is not constant; less towards the ends.
        mounting_deg, mounting_mm: attitude and position of a camera on the robot.
        measured_deg, measured_mm: attitude and position in a POS file that does not give its own.
    """

    sway_deg: float = field(default=0.3, metadata={"above": 0.0})
    sway_mm: float = field(default=0.7, metadata={"above": 0.0})
    wander_mm: float = field(default=1.0, metadata={"minimum": 0.0})
    mounting_deg: float = field(default=0.3, metadata={"minimum": 0.0})
    mounting_mm: float = field(default=0.5, metadata={"minimum": 0.0})
    measured_deg: float = field(default=0.1, metadata={"above": 0.0})
    measured_mm: float = field(default=1.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class RobotPriors:
    """What is known of the robot before any image is looked at; standard deviations in metres and radians.

    Attributes:
        y_m: (frames,) the body's place along the cable.
        body_sigmas: (frames, 6) rotation, then place.
        standoff_m: from each camera to the axis.
        mount_sigmas: (6,) of a camera on the body: rotation, then place.
    """

    y_m: Array
    body_sigmas: Array
    standoff_m: float
    mount_sigmas: Array


def robot_priors(robot: Robot, cable: Cable, frames: FrameSequence, options: PosOptions) -> RobotPriors:
    """What the constructed POS says of the robot itself, for the joint adjustment of its cameras.

    The ends of the travel are held: they are what gives the model its scale, and how well they are known is
    added to the result as a whole.  Between them the speed wanders smoothly, so one frame's place says little
    that its neighbours' do not: each gets the sigma of a bridge, LOOSE times.
    """
    y_m = frames.places_m(cable.travel_m)
    fraction = y_m / cable.travel_m
    bridge = LOOSE * options.wander_mm / 1000 * 2 * np.sqrt(fraction * (1 - fraction))
    body = np.empty((len(y_m), 6))
    body[:, :3] = radians(options.sway_deg)
    body[:, 3:] = options.sway_mm / 1000
    body[:, 4] = np.hypot(bridge, END_SIGMA_M)
    mount = [radians(options.mounting_deg)] * 3 + [options.mounting_mm / 1000] * 3
    return RobotPriors(
        y_m=y_m, body_sigmas=body, standoff_m=robot.standoff_m, mount_sigmas=np.maximum(mount, 1e-7)
    )


def travel_share_sigma(cable: Cable) -> float:
    """Relative standard deviation of the travel, and so of every length in the model."""
    return cable.travel_sigma_mm / 1000 / cable.travel_m


def pos_of_block(survey: Survey, block: Block, frames: FrameSequence, options: PosOptions) -> PosPriors:
    """Give the block's POS: read where the survey names a file, else constructed.

    Raises:
        StageError: the file does not fit; see :func:`read_pos`.
    """
    if block.pos is None:
        return construct_pos(block, survey.robot, survey.cable, frames, options)
    return read_pos(block.pos, block, frames, options.measured_deg, options.measured_mm)


def construct_pos(
    block: Block, robot: Robot, cable: Cable, frames: FrameSequence, options: PosOptions
) -> PosPriors:
    """Construct the POS from travel and time (paper, section 3.1).

    Frame k lies at y + (k - 1) l with l = travel / (n - 1); frames that are not all of the source's lie at
    their fraction of it, those of an unordered source where the pictures put them.  All else is nominal.

    The sigmas of the projection centre: the robot's rotation moves a camera at the end of the arm of length
    stand-off along the cable and around it, but hardly towards it.  Along the cable there is also the wander
    of the speed, a bridge held at both ends (sigma of a Brownian bridge), and the travel's own error, which
    grows along the way.
    """
    y_m = frames.places_m(cable.travel_m)
    poses = nominal_pose(block.angle_deg, robot.standoff_m, y_m, block.travel_in_image)
    fraction = frames.places_m(1.0)
    return PosPriors(poses=poses, sigmas=_constructed_sigmas(block, robot, cable, fraction, options))


def _constructed_sigmas(
    block: Block, robot: Robot, cable: Cable, fraction: Array, options: PosOptions
) -> Array:
    """(n, 6) for frames at these fractions of the travel."""
    rotation = radians(sqrt(options.sway_deg**2 + options.mounting_deg**2))
    across = sqrt(options.sway_mm**2 + options.mounting_mm**2) / 1000
    lever = robot.standoff_m * radians(options.sway_deg)
    bridge = options.wander_mm / 1000 * 2 * np.sqrt(fraction * (1 - fraction))
    travel = cable.travel_sigma_mm / 1000 * fraction
    azimuth = radians(block.angle_deg)
    sigmas = np.empty((len(fraction), 6))
    sigmas[:, :3] = rotation
    sigmas[:, 3] = np.hypot(across, lever * sin(azimuth))
    sigmas[:, 4] = np.sqrt((options.mounting_mm / 1000) ** 2 + lever**2 + bridge**2 + travel**2)
    sigmas[:, 5] = np.hypot(across, lever * cos(azimuth))
    return sigmas
