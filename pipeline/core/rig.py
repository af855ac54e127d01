"""The geometry that is adjusted: a rig of cameras carried along the cable, and the points it sees.

One frame is one moment: the robot's *body* has a pose in the cable frame, and every camera hangs on the body
by its *mounting*.  A single camera is the rig whose mounting is the identity.  This module projects and
differentiates; :mod:`pipeline.core.bundle` solves.

Perturbations used everywhere (and in covariances): rotations are perturbed on the left, R <- exp([w]x) R with
w in radians about the rotated frame's own axes; centres are perturbed by addition, in metres.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import project_with_jacobian
from pipeline.core.rotations import cross_matrix, rotation_from_vector
from pipeline.core.vocabulary import Array

POSE_PARAMETERS = 6
LENS_PARAMETERS = 4


@dataclass(frozen=True, kw_only=True)
class Rig:
    """The state of the adjustment.

    Attributes:
        body_rotations: (F, 3, 3) body_from_cable, one a frame.
        body_centres: (F, 3) origin of the body in the cable frame, metres.
        mount_rotations: (C, 3, 3) cam_from_body, one a camera.
        mount_centres: (C, 3) projection centre in the body frame, metres.
        lenses: (C, 4) focal length, principal point x, y in pixels, and the bend q
            (:func:`pipeline.core.division.unknowns`).
        points: (M, 3) tie points in the cable frame, metres.
    """

    body_rotations: Array
    body_centres: Array
    mount_rotations: Array
    mount_centres: Array
    lenses: Array
    points: Array

    @property
    def unknowns(self) -> int:
        """Number of orientation parameters: six a body pose, six a mounting, four a lens."""
        cameras = len(self.mount_rotations)
        return POSE_PARAMETERS * (len(self.body_rotations) + cameras) + LENS_PARAMETERS * cameras

    def moved(self, step: Array, point_steps: Array) -> "Rig":
        """The state after a step.

        Args:
            step: (unknowns,) in the order bodies, mountings, lenses; see the module for the perturbation.
            point_steps: (M, 3) metres.
        """
        frames, cameras = len(self.body_rotations), len(self.mount_rotations)
        poses = step[: POSE_PARAMETERS * (frames + cameras)].reshape(-1, POSE_PARAMETERS)
        turns = rotation_from_vector(poses[:, :3])
        return replace(
            self,
            body_rotations=turns[:frames] @ self.body_rotations,
            body_centres=self.body_centres + poses[:frames, 3:],
            mount_rotations=turns[frames:] @ self.mount_rotations,
            mount_centres=self.mount_centres + poses[frames:, 3:],
            lenses=self.lenses + step[POSE_PARAMETERS * (frames + cameras) :].reshape(-1, LENS_PARAMETERS),
            points=self.points + point_steps,
        )


@dataclass(frozen=True, kw_only=True)
class Observations:
    """Image measurements of tie points.

    Attributes:
        frame, camera, point: (N,) int64 indices into the rig.
        pixels: (N, 2) as the camera measured them, lens distortion included.
        looseness: (N,) standard deviation of each, in units of the adjustment's own; (N, 2) where it is not
            the same along the rows and the columns; None: all alike.
    """

    frame: NDArray[np.int64]
    camera: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    looseness: Array | None = None

    def __len__(self) -> int:
        return len(self.point)

    def subset(self, keep: NDArray[np.bool_]) -> "Observations":
        """The observations where ``keep`` (N,) is true."""
        return Observations(
            frame=self.frame[keep],
            camera=self.camera[keep],
            point=self.point[keep],
            pixels=self.pixels[keep],
            looseness=None if self.looseness is None else self.looseness[keep],
        )


@dataclass(frozen=True, kw_only=True)
class Linearisation:
    """The observation equations at one state.

    Attributes:
        residuals: (N, 2) measured minus projected, pixels over looseness; NaN where a point cannot be
            projected.
        orientation: (N, 2, 16) derivative of the projection by body pose, mounting and lens.
        columns: (N, 16) int64, which unknown each of the 16 derivatives belongs to.
        points: (N, 2, 3) derivative by the point.
    """

    residuals: Array
    orientation: Array
    columns: NDArray[np.int64]
    points: Array


def points_in_camera(rig: Rig, observations: Observations) -> tuple[Array, Array]:
    """Each observation's point in its body and in its camera, both (N, 3) metres."""
    offsets = rig.points[observations.point] - rig.body_centres[observations.frame]
    in_body = np.einsum("nij,nj->ni", rig.body_rotations[observations.frame], offsets)
    arms = in_body - rig.mount_centres[observations.camera]
    return in_body, np.einsum("nij,nj->ni", rig.mount_rotations[observations.camera], arms)


def linearise(rig: Rig, observations: Observations) -> Linearisation:
    """Residuals and derivatives of every observation (chain rule over lens, mounting and body)."""
    in_body, in_camera = points_in_camera(rig, observations)
    pixels, by_camera_point, by_lens = project_with_jacobian(rig.lenses[observations.camera], in_camera)
    mount = rig.mount_rotations[observations.camera]
    body = rig.body_rotations[observations.frame]
    by_body_point = by_camera_point @ mount
    by_point = by_body_point @ body
    orientation = np.concatenate(
        [
            -by_body_point @ cross_matrix(in_body),
            -by_point,
            -by_camera_point @ cross_matrix(in_camera),
            -by_body_point,
            by_lens,
        ],
        axis=2,
    )
    frames, cameras = len(rig.body_rotations), len(rig.mount_rotations)
    starts = [
        POSE_PARAMETERS * observations.frame,
        POSE_PARAMETERS * (frames + observations.camera),
        POSE_PARAMETERS * (frames + cameras) + LENS_PARAMETERS * observations.camera,
    ]
    sizes = [POSE_PARAMETERS, POSE_PARAMETERS, LENS_PARAMETERS]
    columns = np.concatenate([s[:, None] + np.arange(n) for s, n in zip(starts, sizes, strict=True)], axis=1)
    residuals = observations.pixels - pixels
    if observations.looseness is not None:
        share = 1 / observations.looseness.reshape(len(observations), -1)
        residuals = residuals * share
        orientation, by_point = orientation * share[..., None], by_point * share[..., None]
    return Linearisation(residuals=residuals, orientation=orientation, columns=columns, points=by_point)
