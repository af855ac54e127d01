"""The dense surface of a block as a record, and the options of its making."""

from dataclasses import dataclass, field
from enum import StrEnum

from pipeline.cable.surface_view import Image
from pipeline.core.axis import AxisCurve
from pipeline.core.vocabulary import Array


class DenseMethod(StrEnum):
    """Who matches densely."""

    SWEEP = "sweep"
    PATCH_MATCH = "patch-match"


@dataclass(frozen=True, kw_only=True)
class DenseOptions:
    """How the surface is swept.

    Attributes:
        method: "sweep", our own on the CPU; "patch-match", COLMAP's, where it was built with CUDA.
        cell_mm: side of a cell; 0 takes the ground sample distance.
        coarse: coarse cells are so many fine cells wide.
        limb_deg: cells further than this from the camera's azimuth are not swept: there the outline begins.
        margin_mm: swept length beyond the first and the last frame.
        search_mm: half of the coarse search range about the block's fitted radius.
        window: side of the last comparison window in fine cells, odd.
        detail_cells: brightness is counted from that of surroundings so wide (sigma of a Gaussian), so that
            the shading by lamps that move along is not matched; 0 matches it.
        baselines_mm: distances to the frames compared with, on either side.
        least_score: cells whose agreement is lower are masked.
        consistency_mm: cells whose two half-results differ by more are masked.
        broad_below: where a smaller share of the surface than this stands, broad windows fill the rest.
    """

    method: DenseMethod = DenseMethod.SWEEP
    cell_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    coarse: int = field(default=4, metadata={"minimum": 1})
    limb_deg: float = field(default=60.0, metadata={"above": 0.0, "maximum": 85.0})
    margin_mm: float = field(default=25.0, metadata={"minimum": 0.0})
    search_mm: float = field(default=5.0, metadata={"above": 0.0})
    window: int = field(default=9, metadata={"minimum": 3})
    detail_cells: float = field(default=1.5, metadata={"minimum": 0.0})
    baselines_mm: tuple[float, ...] = field(default=(40.0, 80.0, 100.0, 120.0), metadata={"above": 0.0})
    least_score: float = field(default=0.5, metadata={"minimum": 0.0, "maximum": 1.0})
    consistency_mm: float = field(default=0.35, metadata={"above": 0.0})
    broad_below: float = field(default=0.7, metadata={"minimum": 0.0, "maximum": 1.0})


@dataclass(frozen=True, kw_only=True)
class RadiusMap:
    """The dense surface of one block.

    Attributes:
        axis: the axis that radii are counted from, block's own.
        azimuth: (m,) radians, evenly spaced.
        y_m: (n,) metres, evenly spaced.
        radius_m: (n, m) float32, NaN where masked.
        score: (n, m) float32 agreement of the frames, NaN where not swept.
        noise_mm: standard deviation of a cell's radius, from the two half-results.
        window_mm: side of the window that a cell was matched in, mean over the cells: noise is alike over it.
        ground_sample_mm: size of a pixel on the surface.
        coverage: share of the swept cells that stand.
    """

    axis: AxisCurve
    azimuth: Array
    y_m: Array
    radius_m: Image
    score: Image
    noise_mm: float
    window_mm: float
    ground_sample_mm: float
    coverage: float
