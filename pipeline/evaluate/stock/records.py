"""The records of the comparison with stock COLMAP: options, a block's model, and what came out."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array, Poses


@dataclass(frozen=True, kw_only=True)
class StockOptions:
    """How COLMAP is run and its points are measured; all that is not named here is COLMAP's own default.

    Attributes:
        max_features: most SIFT features in an image (COLMAP's own is 8192, which is for larger pictures).
        overlap: how many of the following images each image is matched with.
        masks: leave the background out.
        threads: for each step; -1 takes every core.
        seed: of COLMAP's random choices.
        slab_mm: points within this distance of a station, along the cable, belong to it.
        limb_deg: points farther around than this from the camera's side are silhouette, not surface.
        least_points: a station with fewer points is not measured.
    """

    max_features: int = field(default=4000, metadata={"above": 0})
    overlap: int = field(default=10, metadata={"above": 0})
    masks: bool = True
    threads: int = -1
    seed: int = 0
    slab_mm: float = field(default=15.0, metadata={"above": 0.0})
    limb_deg: float = field(default=65.0, metadata={"above": 0.0, "maximum": 90.0})
    least_points: int = field(default=12, metadata={"minimum": 3})


@dataclass(frozen=True, kw_only=True)
class StepSeconds:
    """Wall-clock seconds of the sparse reconstruction; masks, which a user makes beforehand, are apart."""

    features: float = 0.0
    matching: float = 0.0
    mapping: float = 0.0
    total: float = 0.0
    masks: float = 0.0

    def __add__(self, other: "StepSeconds") -> "StepSeconds":
        return StepSeconds(
            features=self.features + other.features,
            matching=self.matching + other.matching,
            mapping=self.mapping + other.mapping,
            total=self.total + other.total,
            masks=self.masks + other.masks,
        )


@dataclass(frozen=True, kw_only=True)
class StockModel:
    """COLMAP's largest model of one block, in the model's own frame and unit.

    Attributes:
        frames: (n,) int64, places of the registered images among the block's images, ascending.
        poses: their n poses, cam_from_model.
        points: (m, 3) sparse points.
        focal_px, reprojection_px: of the model.
    """

    frames: NDArray[np.int64]
    poses: Poses
    points: Array
    focal_px: float
    reprojection_px: float


@dataclass(frozen=True, kw_only=True)
class StockBlock:
    """One block, reconstructed alone.

    Attributes:
        name: of the block.
        registered, images: registered images, and all of them.
        points: sparse points of the model.
        reprojection_px, focal_px: of the model; None without one.
        seconds: what it took.
        diameters: station to diameter in millimetres; None where it could not be measured.
        failure: one sentence, None when all stations were measured.
    """

    name: str
    registered: int
    images: int
    points: int
    reprojection_px: float | None
    focal_px: float | None
    seconds: StepSeconds
    diameters: dict[str, float | None]
    failure: str | None


@dataclass(frozen=True, kw_only=True)
class StockStation:
    """A station: the mean of the blocks' diameters against truth, millimetres; None where no block saw it."""

    name: str
    position_m: float
    truth_mm: float
    diameter_mm: float | None
    error_mm: float | None


@dataclass(frozen=True, kw_only=True)
class StockResult:
    """The comparison.

    Attributes:
        mae_mm: mean absolute error over the measured stations, blocks averaged first, so that what is wrong
            in opposite directions on opposite sides (the lever of the robot's sway) cancels; None when
            nothing was measured.
        mae_of_single_blocks_mm: the same without averaging first: what to expect of one strip.
        stations: blocks averaged.
        per_block: each block alone.
        seconds: sums over the blocks.
        failure: what could not be had, None when every block gave every station.
    """

    mae_mm: float | None
    mae_of_single_blocks_mm: float | None
    stations: tuple[StockStation, ...]
    per_block: tuple[StockBlock, ...]
    seconds: StepSeconds
    failure: str | None
