"""The geometry that is adjusted: a rig of cameras carried along the cable, and the points it sees.

One frame is one moment: the robot's *body* has a pose in the cable frame, and every camera hangs on the body
by its *mounting*.  A single camera is the rig whose mounting is the identity.  A rolling shutter reads the
rows one after the other while the robot travels on: a measurement's *moment* says how far the body is then
from where it was in the middle of the frame.  This module projects and differentiates;
:mod:`pipeline.core.bundle` solves.

Perturbations used everywhere (and in covariances): rotations are perturbed on the left, R <- exp([w]x) R with
w in radians about the rotated frame's own axes; centres are perturbed by addition, in metres.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import project_with_jacobian
from pipeline.core.rotations import rotation_from_vector
from pipeline.core.vocabulary import Array

POSE_PARAMETERS = 6
LENS_PARAMETERS = 4
IMAGE_PARAMETERS = 2 * POSE_PARAMETERS + LENS_PARAMETERS + 1
"""What one image hangs on: body pose, mounting, lens, readout."""
OBSERVATIONS_PER_RUN = 4096


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
        readout_m: way along +y of the cable that the body travels between the first row and the last.
    """

    body_rotations: Array
    body_centres: Array
    mount_rotations: Array
    mount_centres: Array
    lenses: Array
    points: Array
    readout_m: float = 0.0

    @property
    def unknowns(self) -> int:
        """Number of orientation parameters: six a body pose, six a mounting, four a lens, the readout."""
        return self.lens_unknowns.stop + 1

    @property
    def lens_unknowns(self) -> slice:
        """Which of them are the lenses'."""
        cameras = len(self.mount_rotations)
        first = POSE_PARAMETERS * (len(self.body_rotations) + cameras)
        return slice(first, first + LENS_PARAMETERS * cameras)

    def moved(self, step: Array, point_steps: Array) -> "Rig":
        """The state after a step.

        Args:
            step: (unknowns,) in the order bodies, mountings, lenses, readout; see the module for the
                perturbation.
            point_steps: (M, 3) metres.
        """
        frames, lenses = len(self.body_rotations), self.lens_unknowns
        poses = step[: lenses.start].reshape(-1, POSE_PARAMETERS)
        turns = rotation_from_vector(poses[:, :3])
        return replace(
            self,
            body_rotations=turns[:frames] @ self.body_rotations,
            body_centres=self.body_centres + poses[:frames, 3:],
            mount_rotations=turns[frames:] @ self.mount_rotations,
            mount_centres=self.mount_centres + poses[frames:, 3:],
            lenses=self.lenses + step[lenses].reshape(-1, LENS_PARAMETERS),
            points=self.points + point_steps,
            readout_m=self.readout_m + float(step[-1]),
        )


@dataclass(frozen=True, kw_only=True)
class Observations:
    """Image measurements of tie points.

    Attributes:
        frame, camera, point: (N,) int64 indices into the rig.
        pixels: (N, 2) as the camera measured them, lens distortion included.
        looseness: (N,) standard deviation of each, in units of the adjustment's own; (N, 2) where it is not
            the same along the rows and the columns; None: all alike.
        moment: (N,) when its row was read, from -0.5 (the first) to 0.5 (the last); None: all rows at once.
    """

    frame: NDArray[np.int64]
    camera: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    looseness: Array | None = None
    moment: Array | None = None

    def __len__(self) -> int:
        return len(self.point)

    def subset(self, keep: NDArray[np.bool_] | NDArray[np.int64] | slice) -> "Observations":
        """The observations where ``keep`` (N,) is true, or those of these numbers, or a run of them."""
        return Observations(
            frame=self.frame[keep],
            camera=self.camera[keep],
            point=self.point[keep],
            pixels=self.pixels[keep],
            looseness=None if self.looseness is None else self.looseness[keep],
            moment=None if self.moment is None else self.moment[keep],
        )


@dataclass(frozen=True, kw_only=True)
class Linearisation:
    """The observation equations at one state.

    Attributes:
        residuals: (N, 2) measured minus projected, pixels over looseness; NaN where a point cannot be
            projected (its derivatives are 0).
        orientation: (17, 2, N) derivative of the projection by body pose, mounting, lens and readout.
        points: (3, 2, N) derivative by the point.
        point, image: (N,) int64 the point and the image of each observation.
        columns: (images, 17) int64, which unknown each of an image's 17 derivatives belongs to.
    """

    residuals: Array
    orientation: Array
    points: Array
    point: NDArray[np.int64]
    image: NDArray[np.int64]
    columns: NDArray[np.int64]


def moments(rows_px: Array, heights_px: Array | float) -> Array:
    """When rows (n,) of frames so high were read, one after the other: from -0.5, the first, to 0.5."""
    return rows_px / heights_px - 0.5


def points_in_camera(rig: Rig, observations: Observations) -> tuple[Array, Array]:
    """Each observation's point in its body and in its camera, both (N, 3) metres; the N last in memory."""
    offsets = _each(rig.points, observations.point) - _each(rig.body_centres, observations.frame)
    if observations.moment is not None:
        offsets[1] -= rig.readout_m * observations.moment
    in_body = _turned(_each(rig.body_rotations, observations.frame), offsets)
    arms = in_body - _each(rig.mount_centres, observations.camera)
    return in_body.T, _turned(_each(rig.mount_rotations, observations.camera), arms).T


def _each(values: Array, index: NDArray[np.int64]) -> Array:
    """``values[index]`` with the observations last, so that they lie side by side in memory."""
    return np.take(np.ascontiguousarray(np.moveaxis(values, 0, -1)), index, axis=-1)


def _turned(rotations: Array, vectors: Array) -> Array:
    """Rotations (3, 3, n) times vectors (3, n)."""
    product = rotations[:, 0] * vectors[0]
    for j in (1, 2):
        product += rotations[:, j] * vectors[j]
    return product


def linearise(rig: Rig, observations: Observations, *, by_orientation: bool = True) -> Linearisation:
    """Residuals and derivatives of every observation (chain rule over lens, mounting and body).

    Args:
        rig: the state.
        observations: image measurements.
        by_orientation: false leaves the derivatives by the orientation out: (0, 2, N).
    """
    count, cameras = len(observations), len(rig.mount_rotations)
    residuals, points = np.empty((2, count)), np.empty((3, 2, count))
    orientation = np.empty((IMAGE_PARAMETERS if by_orientation else 0, 2, count))
    # in runs of observations whose arrays stay in the processor's cache
    for first in range(0, count, OBSERVATIONS_PER_RUN):
        run = slice(first, first + OBSERVATIONS_PER_RUN)
        _linearise_run(
            rig, observations.subset(run), residuals[:, run], orientation[..., run], points[..., run]
        )
    lost = np.flatnonzero(~np.isfinite(residuals).all(axis=0))
    orientation[..., lost] = points[..., lost] = 0
    return Linearisation(
        residuals=residuals.T,
        orientation=orientation,
        points=points,
        point=observations.point,
        image=observations.frame * cameras + observations.camera,
        columns=_columns(len(rig.body_rotations), cameras),
    )


def _linearise_run(rig: Rig, seen: Observations, residuals: Array, orientation: Array, points: Array) -> None:
    """Fill residuals (2, n) and derivatives (17 or 0, 2, n), (3, 2, n) of a run of observations."""
    in_body, in_camera = points_in_camera(rig, seen)
    pixels, by_camera_point, by_lens = project_with_jacobian(rig.lenses[seen.camera], in_camera)
    body_rotations = _each(rig.body_rotations, seen.frame)
    mount_rotations = _each(rig.mount_rotations, seen.camera)
    towards_camera = by_camera_point.transpose(2, 1, 0)
    by_body_point = _times(towards_camera, mount_rotations)
    points[:] = _times(by_body_point, body_rotations)
    residuals[:] = (seen.pixels - pixels).T
    if len(orientation):
        _cross(in_body.T, by_body_point, orientation[0:3])
        np.negative(points, out=orientation[3:6])
        _cross(in_camera.T, towards_camera, orientation[6:9])
        np.negative(by_body_point, out=orientation[9:12])
        orientation[12:16] = by_lens.transpose(2, 1, 0)
        orientation[16] = 0.0 if seen.moment is None else -points[1] * seen.moment
    if seen.looseness is not None:
        share = 1 / seen.looseness.reshape(len(seen), -1).T
        for values in (residuals, orientation, points):
            values *= share


def _times(rows: Array, matrices: Array) -> Array:
    """Row vectors (3, 2, n), two for each of n matrices (3, 3, n), times the matrices: (3, 2, n)."""
    product = rows[0] * matrices[0][:, None]
    for i in (1, 2):
        product += rows[i] * matrices[i][:, None]
    return product


def _cross(left: Array, right: Array, out: Array) -> None:
    """left (3, n) x right (3, 2, n): what -g [p]x is for row vectors g, out = p x g."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        np.multiply(left[j], right[k], out=out[i])
        out[i] -= left[k] * right[j]


def _columns(frames: int, cameras: int) -> NDArray[np.int64]:
    """(frames x cameras, 17) the unknowns of each image."""
    frame, camera = (n.reshape(-1, 1) for n in np.indices((frames, cameras)))
    mounts, lenses = POSE_PARAMETERS * frames, POSE_PARAMETERS * (frames + cameras)
    pose = np.arange(POSE_PARAMETERS)
    return np.concatenate(
        [
            POSE_PARAMETERS * frame + pose,
            mounts + POSE_PARAMETERS * camera + pose,
            lenses + LENS_PARAMETERS * camera + np.arange(LENS_PARAMETERS),
            np.full_like(camera, lenses + LENS_PARAMETERS * cameras),
        ],
        axis=1,
    )
