"""What the adjustment of one block is told, and what it gives; how it is done is in ``adjust.py``."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array, Lens, Poses


@dataclass(frozen=True, kw_only=True)
class AdjustOptions:
    """How the block is adjusted.

    Attributes:
        points: so many tie points orient the block, those seen most often; all are intersected afterwards.
        sigma_px: standard deviation of an image measurement.
        loss_scales_px: Cauchy scales of the successive adjustments, loose to tight.
        gross_px: after the loose adjustment, measurements further off than this are left out.
        least_keypoints: a frame with fewer accepted measurements does not count as calibrated.
        correlation_m: travel over which the robot's sway stays alike; the POS of frames closer together than
            this is no independent evidence of where the block lies.
    """

    points: int = field(default=2500, metadata={"minimum": 50})
    sigma_px: float = field(default=0.2, metadata={"above": 0.0})
    loss_scales_px: tuple[float, ...] = field(default=(8.0, 1.0, 0.5), metadata={"above": 0.0})
    gross_px: float = field(default=1.5, metadata={"above": 0.0})
    least_keypoints: int = field(default=20, metadata={"minimum": 1})
    correlation_m: float = field(default=0.08, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class LensEffect:
    """The same block adjusted without lens correction (figures 5 and 6).

    Attributes:
        points_uncorrected: (m, 3) tie points that the uncorrected adjustment gives, metres.
        reprojection_px: its root mean square residual.
    """

    points_uncorrected: Array
    reprojection_px: float


@dataclass(frozen=True, kw_only=True)
class Orientation:
    """One adjusted block.

    Attributes:
        lens: of the original frames.
        poses: adjusted, cam_from_world.
        points: (m, 3) tie points, metres in the cable frame.
        frame, point: (n,) int64 of each accepted measurement.
        pixels: (n, 2) accepted measurements, original frames.
        residuals: (n, 2) measured minus projected, pixels.
        keypoints: (frames,) int64 accepted measurements in each frame.
        calibrated: (frames,) bool.
        reprojection_px: root mean square length of the accepted residuals.
        datum_origin: (3,) metres; centre of the seven-parameter datum.
        datum_information: (7, 7) weight with which the POS holds the block against a similarity about the
            datum origin: rotation vector (rad), shift (m), scale.
        lens_effect: None where the lens has no distortion to correct.
    """

    lens: Lens
    poses: Poses
    points: Array
    frame: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    residuals: Array
    keypoints: NDArray[np.int64]
    calibrated: NDArray[np.bool_]
    reprojection_px: float
    datum_origin: Array
    datum_information: Array
    lens_effect: LensEffect | None
