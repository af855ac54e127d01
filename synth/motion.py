"""The true motion of the ring and the poses that follow; pure, from the spec only.

The ring is one rigid body on the cable axis; it travels along +y, wanders in speed and sways, and carries its
cameras with it, lever arm included.  Own formulas, shared with nothing in the pipeline.
"""

import math

import numpy as np

from pipeline.core.vocabulary import Array, Poses, TravelDirection
from synth.spec import Robot, Spec

SWAY_WAVES = 5
SWAY_CYCLES = (0.3, 4.0)  # slowest and fastest sway, cycles over the whole travel: smooth from frame to frame
WANDER_HARMONICS = 4


def block_poses(spec: Spec, frame_shift: float = 0.0) -> tuple[Poses, ...]:
    """True cam_from_world of every block and frame.

    Args:
        spec: the survey.
        frame_shift: moment within the frame interval, for motion blur; 0 is the moment of the frame.

    Returns:
        One sequence of poses per block, in the order of ``spec.blocks``.
    """
    moments = (np.arange(spec.robot.frames) + frame_shift) / (spec.robot.frames - 1)
    poses = []
    for index, angle_deg in enumerate(spec.angles_deg):
        run = 0 if spec.robot.synchronised else index
        ring_rotation, ring_origin = ring_motion(spec, moments, run)
        rotation_in_ring, centre_in_ring = _mounted_camera(spec, index, math.radians(angle_deg))
        rotations = ring_rotation @ rotation_in_ring
        centres = ring_origin + ring_rotation @ centre_in_ring
        cam_from_world = np.swapaxes(rotations, 1, 2)
        poses.append(
            Poses(rotations=cam_from_world, translations=-np.einsum("nij,nj->ni", cam_from_world, centres))
        )
    return tuple(poses)


def ring_motion(spec: Spec, moments: Array, run: int = 0) -> tuple[Array, Array]:
    """Attitude and place of the ring.

    Args:
        spec: the survey.
        moments: (n,) fractions of the travel time, 0 to 1.
        run: which pass; passes differ in their random motion.

    Returns:
        world_from_ring rotations (n, 3, 3) and origins (n, 3) in metres.
    """
    robot = spec.robot
    rng = np.random.default_rng([spec.seed, 11, run])
    frames = np.linspace(0.0, 1.0, robot.frames)
    waves = [_sway(rng, frames, moments) for _ in range(5)]
    angles = np.radians(robot.sway_deg) * np.stack(waves[:3], axis=1)
    origin = np.zeros((len(moments), 3))
    origin[:, 0] = robot.sway_mm / 1000.0 * waves[3]
    origin[:, 1] = robot.travel_m * moments + robot.speed_wander_mm / 1000.0 * _wander(rng, frames, moments)
    origin[:, 2] = robot.sway_mm / 1000.0 * waves[4]
    return np.stack([rotation_from_vector(a) for a in angles]), origin


def _sway(rng: np.random.Generator, frames: Array, moments: Array) -> Array:
    """Smooth random function of unit RMS over the frames: a few sines of random frequency and phase."""
    cycles = rng.uniform(*SWAY_CYCLES, SWAY_WAVES)
    phases = rng.uniform(0.0, 2.0 * math.pi, SWAY_WAVES)

    def wave(t: Array) -> Array:
        return np.asarray(np.sin(2.0 * math.pi * np.outer(t, cycles) + phases).sum(axis=1), float)

    return wave(moments) / np.sqrt(np.mean(wave(frames) ** 2))


def _wander(rng: np.random.Generator, frames: Array, moments: Array) -> Array:
    """Smooth random function of unit RMS over the frames that vanishes at 0 and 1."""
    if len(frames) < 3:
        return np.zeros(len(moments))
    weights = rng.standard_normal(WANDER_HARMONICS) / np.arange(1, WANDER_HARMONICS + 1)

    def wave(t: Array) -> Array:
        return np.asarray(np.sin(math.pi * np.outer(t, np.arange(1, WANDER_HARMONICS + 1))) @ weights, float)

    return wave(moments) / np.sqrt(np.mean(wave(frames) ** 2))


def _mounted_camera(spec: Spec, index: int, angle_rad: float) -> tuple[Array, Array]:
    """ring_from_cam rotation (3, 3) and centre in the ring (3,) of one camera, mounting error included."""
    robot = spec.robot
    rng = np.random.default_rng([spec.seed, 21, index])
    yaw, pitch, roll = np.radians(robot.mounting_deg) * rng.standard_normal(3)
    offset = robot.mounting_mm / 1000.0 * rng.standard_normal(3)
    error = _about(1, yaw) @ _about(0, pitch) @ _about(2, roll)
    centre = robot.standoff_m * np.array([math.cos(angle_rad), 0.0, -math.sin(angle_rad)])
    return nominal_rotation(robot, angle_rad) @ error, centre + offset


def nominal_rotation(robot: Robot, angle_rad: float) -> Array:
    """ring_from_cam (3, 3) of a camera at this azimuth that looks at the axis; columns are its axes."""
    travel = np.array([0.0, 1.0, 0.0])
    forward = np.array([-math.cos(angle_rad), 0.0, math.sin(angle_rad)])
    match robot.travel_in_image:
        case TravelDirection.RIGHT:
            right = travel
        case TravelDirection.LEFT:
            right = -travel
        case TravelDirection.DOWN:
            right = np.cross(travel, forward)
        case TravelDirection.UP:
            right = -np.cross(travel, forward)
    return np.stack([right, np.cross(forward, right), forward], axis=1)


def rotation_from_vector(vector_rad: Array) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,), Rodrigues' formula."""
    angle = float(np.linalg.norm(vector_rad))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector_rad / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def _about(axis: int, angle_rad: float) -> Array:
    vector = np.zeros(3)
    vector[axis] = angle_rad
    return rotation_from_vector(vector)
