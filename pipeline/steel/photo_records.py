"""What photos of a structure are turned into: options, oriented photos, and their sparse points."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array, Lens, Poses


@dataclass(frozen=True, kw_only=True)
class SparseOptions:
    """How photos are oriented.

    Attributes:
        features: most SIFT features of a photo.
        ratio: a match is nearer than this share of the second best.
        least_matches: photos with fewer verified matches are no pair.
        refine_focal, refine_distortion: whether the adjustment looks for them.
        seed: of COLMAP's random choices.
    """

    features: int = field(default=6000, metadata={"minimum": 200})
    ratio: float = field(default=0.8, metadata={"above": 0.0, "maximum": 1.0})
    least_matches: int = field(default=20, metadata={"minimum": 8})
    refine_focal: bool = True
    refine_distortion: bool = True
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class DepthOptions:
    """How depth maps are made.

    Attributes:
        step_px: a depth for every so many pixels each way.
        neighbours: photos that each one is compared with.
        least_angle_deg, best_angle_deg: rays of neighbours meet at this angle at least, and best at.
        window_px: side of the comparison window, odd.
        candidate_px: two candidate depths lie so far apart in the widest neighbour.
        slope_px: neighbouring depths no farther apart than this in the widest neighbour are one surface,
            whose slope the windows follow.
        least_score: correlation of a depth that is kept.
        agree_px: a depth must come back to within this, in at least ``least_agreeing`` neighbours.
        least_agreeing: see there.
        matching_sigma_px: what the correlation's peak is worth at best; how far the depth maps differ and
            edges nearby come on top.
        most_candidates: depths tried for a pixel.
    """

    step_px: int = field(default=2, metadata={"minimum": 1, "maximum": 16})
    neighbours: int = field(default=6, metadata={"minimum": 1})
    least_angle_deg: float = field(default=4.0, metadata={"above": 0.0})
    best_angle_deg: float = field(default=25.0, metadata={"above": 0.0})
    window_px: int = field(default=9, metadata={"minimum": 3})
    candidate_px: float = field(default=1.2, metadata={"above": 0.1, "maximum": 4.0})
    slope_px: float = field(default=2.5, metadata={"above": 0.0})
    least_score: float = field(default=0.6, metadata={"minimum": 0.0, "maximum": 1.0})
    agree_px: float = field(default=1.0, metadata={"above": 0.0})
    least_agreeing: int = field(default=2, metadata={"minimum": 1})
    matching_sigma_px: float = field(default=0.06, metadata={"above": 0.0})
    most_candidates: int = field(default=400, metadata={"minimum": 16})


@dataclass(frozen=True, kw_only=True)
class OrientedPhotos:
    """Photos in one frame of their own, and the sparse points that tie them.

    Attributes:
        files: one picture each, registered ones only.
        lens: common to all.
        poses: cam_from_photo (the photo frame), n of them.
        points: (m, 3) photo frame.
        observations: (k, 2) int64 of (number of the photo, number of the point).
        pixels: (k, 2).
        left_out: pictures that could not be oriented.
        reprojection_px: root mean square.
    """

    files: tuple[Path, ...]
    lens: Lens
    poses: Poses
    points: Array
    observations: NDArray[np.int64]
    pixels: Array
    left_out: tuple[Path, ...]
    reprojection_px: float
