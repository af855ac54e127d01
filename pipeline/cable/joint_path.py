"""The way of the robot and the size of its ring, with what they are worth: what ties neighbouring segments.

Takes the adjusted bundle; gives where the cameras were along the cable, moment by moment, and how far they
stand from each other.  Leaves out what is made of it (:mod:`pipeline.segments.traverse`).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.core.bundle import BundleResult
from pipeline.core.rig import POSE_PARAMETERS
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class RingPath:
    """Where the ring of cameras was, and its size; standard deviations take the travel as exact.

    Attributes:
        y_m: (frames,) place of the cameras' middle along the cable.
        covariance_m2: (frames, frames) of those places.
        size_m: root mean square distance of the projection centres from their middle.
        size_sigma_m: its standard deviation.
    """

    y_m: Array
    covariance_m2: Array
    size_m: float
    size_sigma_m: float


def ring_path(result: BundleResult) -> RingPath:
    """Carry the adjustment's covariance to the ring's places along the cable and to its size."""
    rig = result.rig
    frames, cameras = len(rig.body_rotations), len(rig.mount_centres)
    middle = rig.mount_centres.mean(axis=0)
    arms = rig.mount_centres - middle
    size_m = float(np.sqrt(np.mean(np.sum(arms**2, axis=1))))
    along = rig.body_rotations[:, :, 1]  # +y of the cable in the body, frame by frame
    by_place, by_size = np.zeros((frames, rig.unknowns)), np.zeros(rig.unknowns)
    for k in range(frames):
        body = POSE_PARAMETERS * k
        by_place[k, body : body + 3] = along[k] @ cross_matrix(middle)
        by_place[k, body + 4] = 1.0
    for camera in range(cameras):
        centre = POSE_PARAMETERS * (frames + camera) + 3
        by_place[:, centre : centre + 3] = along / cameras
        by_size[centre : centre + 3] = arms[camera] / (cameras * size_m)
    return RingPath(
        y_m=rig.body_centres[:, 1] + along @ middle,
        covariance_m2=by_place @ result.covariance @ by_place.T,
        size_m=size_m,
        size_sigma_m=float(np.sqrt(by_size @ result.covariance @ by_size)),
    )
