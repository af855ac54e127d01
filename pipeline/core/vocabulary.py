"""The shared words: frozen records that stages hand to each other.

Frames of reference (the contract, in metres):
    *cable*   y is the cable axis in the direction of travel, y = 0 at the first frame.  A direction around
              the axis is an azimuth a: (cos a, 0, -sin a), the right-hand rule about +y.
    *camera*  x right, y down, z forward.  A pose is always ``cam_from_world`` (world = cable frame).
    *image*   pixels; (0, 0) is the top-left *corner*, so the first pixel's centre is (0.5, 0.5).

Arrays are float64 unless said otherwise; shapes and units stand beside each field.
"""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class LambdaRadius(StrEnum):
    """What the radius r_d of the division model is measured in (paper, equation 15)."""

    HALF_DIAGONAL = "half-diagonal"
    HALF_WIDTH = "half-width"
    FOCAL = "focal"
    PIXEL = "pixel"


class TravelDirection(StrEnum):
    """Image direction in which the robot's travel (+y of the cable frame) points."""

    RIGHT = "right"
    LEFT = "left"
    UP = "up"
    DOWN = "down"


@dataclass(frozen=True, kw_only=True)
class Lens:
    """A camera's interior orientation: pinhole and one-parameter division model.

    Attributes:
        width_px, height_px: image size.
        focal_px: focal length.
        principal_point_px: (x, y), also the distortion centre.
        division_lambda: lambda of equation (15), negative for barrel distortion.
        lambda_radius: unit of the radius that lambda belongs to.
        focal_sigma_px, lambda_sigma: standard deviations; 0 where the value is trusted.
    """

    width_px: int
    height_px: int
    focal_px: float
    principal_point_px: tuple[float, float]
    division_lambda: float
    lambda_radius: LambdaRadius = LambdaRadius.HALF_DIAGONAL
    focal_sigma_px: float = 0.0
    lambda_sigma: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Poses:
    """Exterior orientations of a sequence of frames, cam_from_world.

    Attributes:
        rotations: (n, 3, 3).
        translations: (n, 3), metres; x_cam = R x_world + t.
        readout_m: way along +y that the camera travels between the first row of a frame and the last (rolling
            shutter); the orientations are those of the middle row.
    """

    rotations: Array
    translations: Array
    readout_m: float = 0.0

    def __len__(self) -> int:
        return len(self.rotations)

    @property
    def centres(self) -> Array:
        """Projection centres in the cable frame, (n, 3) metres."""
        return -np.einsum("nji,nj->ni", self.rotations, self.translations)


@dataclass(frozen=True, kw_only=True)
class FrameSequence:
    """The selected frames of one block, in the order of travel, each an image file on disk.

    Attributes:
        block: name of the block.
        files: one image file a frame, as it came from the camera (lens distortion included).
        source_indices: (n,) int64, number of each frame in its source; strictly increasing where the source
            is in the order of travel.
        source_count: number of frames in the source.
        width_px, height_px: image size.
        fractions: (n,) where along the travel each frame was taken, from 0 to 1, found from the pictures of
            an unordered source; None where frame i of the source was taken at i / (source_count - 1).
    """

    block: str
    files: tuple[Path, ...]
    source_indices: NDArray[np.int64]
    source_count: int
    width_px: int
    height_px: int
    fractions: Array | None = None

    def __len__(self) -> int:
        return len(self.files)

    def places_m(self, travel_m: float) -> Array:
        """Predicted place of each frame along the cable, (n,) metres.

        At constant speed (paper, section 3.1) where nothing better is known.
        """
        if self.fractions is not None:
            return travel_m * self.fractions
        return travel_m * self.source_indices / max(self.source_count - 1, 1)


@dataclass(frozen=True, kw_only=True)
class PosPriors:
    """Observed exterior orientation (position and orientation system) with its uncertainty.

    Attributes:
        poses: the observed orientations.
        sigmas: (n, 6) standard deviations: rotation about the camera's own x, y, z in radians, then the
            projection centre along the cable frame's x, y, z in metres.
    """

    poses: Poses
    sigmas: Array
