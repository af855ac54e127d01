"""What stage *mosaic* takes and gives: its options, the blocks, corresponding points, the joined blocks."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.closest_fit import Placement
from pipeline.cable.surface import BlockSurface
from pipeline.cable.texture import UnrolledPicture
from pipeline.cable.unrolled_match import UnrolledMatchOptions
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class MosaicOptions:
    """How blocks are joined.

    Attributes:
        match: how corresponding points are found.
        single_point: use one pair of neighbours only (the paper's way), not every pair that was found.
        sigma_along_mm, sigma_around_mm, sigma_radial_mm: of the difference of two corresponding points.
        surface_mm: of the distance of two surfaces.
        surface_step_mm: distance between the surface points that are compared.
        smooth_mm: surfaces are averaged over this width before they are compared.
    """

    match: UnrolledMatchOptions = field(default_factory=UnrolledMatchOptions)
    single_point: bool = False
    sigma_along_mm: float = field(default=0.06, metadata={"above": 0.0})
    sigma_around_mm: float = field(default=0.1, metadata={"above": 0.0})
    sigma_radial_mm: float = field(default=0.1, metadata={"above": 0.0})
    surface_mm: float = field(default=0.2, metadata={"above": 0.0})
    surface_step_mm: float = field(default=4.0, metadata={"above": 0.0})
    smooth_mm: float = field(default=2.0, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class PointPairs:
    """Corresponding points of two blocks, (k, 3) each, in metres as the blocks stand."""

    first: int
    second: int
    points_first: Array
    points_second: Array


@dataclass(frozen=True, kw_only=True)
class MosaicBlock:
    """What the mosaic needs to know of one block."""

    name: str
    surface: BlockSurface
    keep: NDArray[np.bool_]
    picture: UnrolledPicture
    datum_origin: Array
    datum_information: Array


@dataclass(frozen=True, kw_only=True)
class Join:
    """How two neighbours fit.

    Attributes:
        first, second: the blocks' numbers.
        pairs: corresponding points found or given.
        held: (2, 3) the pair that is held together, metres as the blocks stand.
        residual_mm: (3,) root mean square difference of the pairs along, around and out of the cable.
        surface_mm: root mean square distance of the surfaces where they overlap.
    """

    first: int
    second: int
    pairs: int
    held: Array
    residual_mm: Array
    surface_mm: float


@dataclass(frozen=True, kw_only=True)
class Mosaic:
    """All blocks in one frame.

    Attributes:
        placement: of each block, in the order of the blocks given.
        covariance: (7 b, 7 b) of rotation vectors (rad), shifts (m) and log scales.
        joins: neighbours that were tied.
    """

    placement: Placement
    covariance: Array
    joins: tuple[Join, ...]
