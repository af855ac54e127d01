"""The way of the robot and the size of its ring, with what they are worth: what ties neighbouring segments.

Takes the adjusted bundle; gives where the cameras were along the cable, moment by moment, how far they
stand from each other, and how surely the robot's way is straight.  Leaves out what is made of it
(:mod:`pipeline.segments.traverse`, :mod:`pipeline.segments.bends`).
"""

from dataclasses import dataclass, field

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
        across_covariance: (2 frames, 2 frames) of the middle's places across the cable (m), then of how far
            the cameras lean out of the axis on the mean (rad); mean of the two directions, x and z. Empty in
            runs of earlier versions.
    """

    y_m: Array
    covariance_m2: Array
    size_m: float
    size_sigma_m: float
    across_covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))


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
        across_covariance=(_across(result, 0) + _across(result, 2)) / 2,
    )


def _across(result: BundleResult, axis: int) -> Array:
    """Covariance of places and leans along x (axis 0) or z (2) of the cable, as RingPath holds it.

    A turn w of the whole about the origin moves a place y by w x (0, y, 0): by -w_z y along x and w_x y along
    z.  So these are the leans towards x and z; the cameras' attitudes cam_from_cable turn the other way.
    """
    rig = result.rig
    frames, cameras = len(rig.body_rotations), len(rig.mount_centres)
    middle = rig.mount_centres.mean(axis=0)
    towards = rig.body_rotations[:, :, axis]
    about, sign = (rig.body_rotations[:, :, 2], 1.0) if axis == 0 else (rig.body_rotations[:, :, 0], -1.0)
    places, leans = np.zeros((2, frames, rig.unknowns))
    for k in range(frames):
        body = POSE_PARAMETERS * k
        places[k, body : body + 3] = towards[k] @ cross_matrix(middle)
        places[k, body + 3 + axis] = 1.0
        leans[k, body : body + 3] = sign * about[k]
    for camera, turn in enumerate(rig.mount_rotations):
        first = POSE_PARAMETERS * (frames + camera)
        leans[:, first : first + 3] = sign * about @ turn.T / cameras
        places[:, first + 3 : first + 6] = towards / cameras
    by_unknowns = np.concatenate([places, leans])
    return np.asarray(by_unknowns @ result.covariance @ by_unknowns.T)
