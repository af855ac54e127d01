"""Four cameras on one swaying body about a known cable: exact measurements for the joint adjustment.

Like ``scene.py``, it shares no formula with the pipeline.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.cable.closing import SharedMarks
from pipeline.cable.joint import JointBlock
from pipeline.cable.pos import RobotPriors
from pipeline.core.vocabulary import Poses, TravelDirection
from tests.cable import scene

AZIMUTHS_DEG = (0.0, 90.0, 180.0, 270.0)


def views(sway_deg=0.3, sway_mm=0.7, wander_mm=0.8, seed=2, frames=scene.FRAMES, division_lambda=-0.05):
    """One view a camera, all carried by the same body; the ends of the travel are exact."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(np.radians(rng.normal(0, sway_deg, (frames, 3)))).as_matrix()
    centre = np.stack(
        [
            rng.normal(0, sway_mm / 1000, frames),
            scene.STEP_M * np.arange(frames) + rng.normal(0, wander_mm / 1000, frames),
            rng.normal(0, sway_mm / 1000, frames),
        ],
        axis=1,
    )
    centre[[0, -1], 1] = [0.0, scene.STEP_M * (frames - 1)]
    found = []
    for azimuth in AZIMUTHS_DEG:
        arm = scene.STANDOFF_M * scene.out_of_cable(np.radians(azimuth))
        rotations = scene.nominal_rotation(azimuth) @ turn.transpose(0, 2, 1)
        centres = centre + turn @ arm
        poses = Poses(rotations=rotations, translations=-np.einsum("nij,nj->ni", rotations, centres))
        found.append(scene.Scene(poses=poses, lens=scene.lens(division_lambda)))
    return tuple(found)


def observe(view, points, readout_m=0.0):
    """As ``scene.observe``, by a camera that reads its rows from top to bottom while the robot travels on."""
    frame, point, pixels = scene.observe(view, points)
    for _ in range(3):
        late_m = readout_m * (pixels[:, 1] / scene.HEIGHT_PX - 0.5)
        seen = points[point] - late_m[:, None] * [0.0, 1.0, 0.0]
        pixels = np.concatenate([view.project(k, seen[frame == k]) for k in np.unique(frame)])
    return frame, point, pixels


def blocks(of, noise_px=0.0, seed=6, count=500, lens=None, readout_m=0.0):
    """The blocks as they might come from being adjusted alone: standing by the POS, all measurements kept."""
    rng = np.random.default_rng(seed)
    made = []
    for number, (view, azimuth) in enumerate(zip(of, AZIMUTHS_DEG, strict=True)):
        turn = np.radians(azimuth + rng.uniform(-55, 55, count))
        points = view.points(turn, np.sort(rng.uniform(-0.05, scene.TRAVEL_M + 0.05, count)))
        frame, point, pixels = observe(view, points, readout_m)
        nominal = scene.poses(azimuth, frames=len(view.poses))
        alone = replace(
            scene.true_orientation(view),
            lens=lens or view.lens,
            poses=nominal,
            points=points + rng.normal(0, 3e-4, points.shape),
            frame=frame,
            point=point,
            pixels=pixels + rng.normal(0, noise_px, pixels.shape) if noise_px else pixels,
            residuals=np.zeros_like(pixels),
        )
        made.append(
            JointBlock(
                name=f"Block{number + 1}",
                azimuth_deg=azimuth,
                travel_in_image=TravelDirection.RIGHT,
                orientation=alone,
            )
        )
    return tuple(made)


def marks(of, noise_px=0.0, seed=9, count=60, readout_m=0.0):
    """Marks on the lines between neighbours, seen by both."""
    rng = np.random.default_rng(seed)
    parts = {name: [] for name in ("block", "frame", "mark", "pixels", "points", "pairs")}
    for first in range(len(of)):
        second = (first + 1) % len(of)
        turn = np.radians(AZIMUTHS_DEG[first] + 45 + rng.uniform(-7, 7, count))
        points = of[first].points(turn, np.sort(rng.uniform(0, scene.TRAVEL_M, count)))
        for block in (first, second):
            frame, point, pixels = observe(of[block], points, readout_m)
            parts["block"].append(np.full(len(frame), block))
            parts["frame"].append(frame)
            parts["mark"].append(point + first * count)
            parts["pixels"].append(pixels + rng.normal(0, noise_px, pixels.shape))
        parts["points"].append(points)
        parts["pairs"].append(np.tile([first, second], (count, 1)))
    return SharedMarks(**{name: np.concatenate(values) for name, values in parts.items()})


def no_marks():
    """Blocks that share nothing."""
    whole = np.zeros(0, dtype=np.int64)
    return SharedMarks(
        block=whole,
        frame=whole,
        mark=whole,
        pixels=np.zeros((0, 2)),
        points=np.zeros((0, 3)),
        pairs=np.zeros((0, 2), dtype=np.int64),
    )


def robot(frames=scene.FRAMES):
    """Priors as loose as the sway of ``views``."""
    body = np.tile([np.radians(0.5)] * 3 + [1.5e-3] * 3, (frames, 1))
    body[[0, -1], 4] = 2e-5
    return RobotPriors(
        y_m=scene.STEP_M * np.arange(frames),
        body_sigmas=body,
        standoff_m=scene.STANDOFF_M,
        mount_sigmas=np.array([np.radians(0.2)] * 3 + [3e-4] * 3),
    )
