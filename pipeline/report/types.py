"""The records that the report is made of, filled by the stages.

Takes nothing and computes nothing; arrays are checked for their shape on construction (ValueError), so that a
wrong hand-over fails where it happens and not inside a plot.  Coordinates are in the cable frame
(``pipeline/core/vocabulary.py``); lengths in metres or millimetres as the field's name says.  A number that
is not known is NaN and is shown as a dash.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array, LambdaRadius
from pipeline.report.relief_records import ReliefSummary
from pipeline.report.segment_records import SegmentSummary

Picture = NDArray[np.uint8]


def _check_shape(owner: object, name: str, shape: tuple[int | None, ...]) -> None:
    """Raise ValueError unless ``owner.name`` has that shape; None stands for any length."""
    array: NDArray[Any] = getattr(owner, name)
    fits = array.ndim == len(shape) and all(
        want in (None, got) for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ValueError(f"{type(owner).__name__}.{name} has shape {array.shape}, wanted {shape}")


@dataclass(frozen=True, kw_only=True)
class BlockSummary:
    """One block after the adjustment: a column of Table 1.

    Attributes:
        name: name of the block.
        images, calibrated: frames that went in, and frames whose orientation was found.
        keypoints_per_image: mean number of image points that the adjustment used.
        reprojection_px: mean length of the image residuals, pixels.
        focal_px, focal_sigma_px, principal_point_px, division_lambda, lambda_radius, lambda_sigma: the lens
            that was used; sigma 0 where trusted.
        lens_method: where the lens came from, e.g. ``"given"``, ``"plumb lines"``, ``"chessboard"``.
        coverage_m2: surface area that the block covers.
        resolution_mm: size of a pixel on the surface.
        angle_deg: azimuth of the camera around the axis.
    """

    name: str
    images: int
    calibrated: int
    keypoints_per_image: float
    reprojection_px: float
    focal_px: float
    focal_sigma_px: float
    principal_point_px: tuple[float, float]
    division_lambda: float
    lambda_radius: LambdaRadius
    lambda_sigma: float
    lens_method: str
    coverage_m2: float
    resolution_mm: float
    angle_deg: float


@dataclass(frozen=True, kw_only=True)
class StationResult:
    """The cross section at one station.

    Attributes:
        name, position_m: name, and place along the axis from the first frame.
        diameter_mm, sigma_mm: diameter and its standard deviation, scale included.
        min_mm, max_mm: smallest and largest diameter.
        coverage_deg: arc of the section that carries points, 0 to 360.
        section_mm: (m, 2) points of the section, x and z in the cable frame; m may be 0.
        circle_centre_mm: (x, z) of the fitted circle.
        circle_radius_mm: its radius.
        base_diameter_mm, base_sigma_mm: mean diameter without what stands proud of the sheath or is dented,
            and its standard deviation.
    """

    name: str
    position_m: float
    diameter_mm: float
    sigma_mm: float
    min_mm: float
    max_mm: float
    coverage_deg: float
    section_mm: Array
    circle_centre_mm: tuple[float, float]
    circle_radius_mm: float
    base_diameter_mm: float = float("nan")
    base_sigma_mm: float = float("nan")

    def __post_init__(self) -> None:
        _check_shape(self, "section_mm", (None, 2))


@dataclass(frozen=True, kw_only=True)
class TruthStation:
    """The true diameter at one station; matched to the measured one by its name."""

    name: str
    position_m: float
    diameter_mm: float


@dataclass(frozen=True, kw_only=True)
class LensEffect:
    """What one block would have given without the lens correction (paper, figures 5 and 6).

    Attributes:
        block: name of the block.
        diameter_uncorrected_mm, diameter_corrected_mm: diameter of the cylinder through the block.
        residual_uncorrected_mm, residual_corrected_mm: root mean square distance from that cylinder.
        bow_uncorrected_mm, bow_corrected_mm: largest distance of the axis from its chord.
        points_uncorrected_mm, points_corrected_mm: (n, 3) surface points of both, cable frame, millimetres;
            n may differ between the two.
    """

    block: str
    diameter_uncorrected_mm: float
    diameter_corrected_mm: float
    residual_uncorrected_mm: float
    residual_corrected_mm: float
    bow_uncorrected_mm: float
    bow_corrected_mm: float
    points_uncorrected_mm: Array
    points_corrected_mm: Array

    def __post_init__(self) -> None:
        _check_shape(self, "points_uncorrected_mm", (None, 3))
        _check_shape(self, "points_corrected_mm", (None, 3))


@dataclass(frozen=True, kw_only=True)
class LensPictures:
    """Figures 2 and 3 of the paper for one block: distortion grid, a frame before and after; (h, w, 3)."""

    block: str
    grid: Picture
    before: Picture
    after: Picture

    def __post_init__(self) -> None:
        for name in ("grid", "before", "after"):
            _check_shape(self, name, (None, None, 3))


@dataclass(frozen=True, kw_only=True)
class UnrolledPicture:
    """The surface unrolled: columns are arc length, rows are positions along the cable.

    Attributes:
        image: (h, w, 3) RGB.
        mm_per_px: size of a pixel on the surface, the same both ways.
        theta_range_deg: azimuth at the left and at the right edge of the picture.
        y_range_m: position along the cable at the top and at the bottom edge.
        name: name of the block it shows, or "" for the whole cable.
    """

    image: Picture
    mm_per_px: float
    theta_range_deg: tuple[float, float]
    y_range_m: tuple[float, float]
    name: str = ""

    def __post_init__(self) -> None:
        _check_shape(self, "image", (None, None, 3))


@dataclass(frozen=True, kw_only=True)
class DiameterProfile:
    """The diameter along the axis: position_m, diameter_mm, sigma_mm, each (n,)."""

    position_m: Array
    diameter_mm: Array
    sigma_mm: Array

    def __post_init__(self) -> None:
        for name in ("position_m", "diameter_mm", "sigma_mm"):
            _check_shape(self, name, (len(self.position_m),))


@dataclass(frozen=True, kw_only=True)
class AxisSummary:
    """How straight the cable's axis is.

    Attributes:
        straightness_mm_per_m: largest distance of the axis from its chord over the length of the chord.
        position_m: (n,) places along the axis.
        bow_mm: (n, 2) distance of the axis from its chord there, along x and z of the cable frame.
        centre_mm: (n, 2) the axis itself there, x and z of the cable frame.
        sigma_mm: (n,) standard deviation of the bow, along x and along z; None where it is not told.
    """

    straightness_mm_per_m: float
    position_m: Array
    bow_mm: Array
    centre_mm: Array
    sigma_mm: Array | None = None

    def __post_init__(self) -> None:
        _check_shape(self, "bow_mm", (len(self.position_m), 2))
        _check_shape(self, "centre_mm", (len(self.position_m), 2))


@dataclass(frozen=True, kw_only=True)
class MosaicJoint:
    """How two neighbouring blocks were joined: pairs of corresponding points, and what remains between."""

    first: str
    second: str
    pairs: int
    residual_mm: float


@dataclass(frozen=True, kw_only=True)
class MosaicSummary:
    """How all blocks came together: mosaicking (paper, section 3.3) or the joint adjustment.

    Attributes:
        joints: one entry for each pair of neighbours.
        scale_corrections: block to scale factor (1.0 is none).
        tie_points: points seen from more than one block.
        shared_residual_px: where all cameras were adjusted together, the residual of the shared marks; NaN
            where the blocks were adjusted alone and joined afterwards.
        readout_mm, readout_sigma_mm: way that the robot travels between a frame's first row and its last
            (rolling shutter), and its standard deviation; NaN where it was not asked for.
    """

    joints: tuple[MosaicJoint, ...]
    scale_corrections: Mapping[str, float]
    tie_points: int
    shared_residual_px: float = float("nan")
    readout_mm: float = float("nan")
    readout_sigma_mm: float = float("nan")


@dataclass(frozen=True, kw_only=True)
class SurfacePriorStation:
    """The diameter of one station from the tie points, without and with the surface prior; sigma of both."""

    name: str
    without_mm: float
    with_mm: float
    without_sigma_mm: float
    with_sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class SurfacePriorSummary:
    """What the weak prior that the surface is smooth changes.

    Attributes:
        sigma_mm: by how much the surface may depart from a smooth one.
        used: whether the rest of the report stands on the adjustment with the prior.
        stations: each compared.
    """

    sigma_mm: float
    used: bool
    stations: tuple[SurfacePriorStation, ...]


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A textured triangle mesh.

    Attributes:
        vertices: (n, 3) metres, cable frame.
        normals: (n, 3) unit, outward.
        faces: (m, 3) integers, counter-clockwise seen from outside.
        uv: (n, 2) place in the texture: (0, 0) is the top-left corner of the picture, u right, v *down*.
        texture: (h, w, 3) RGB.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.integer[Any]]
    uv: Array
    texture: Picture

    def __post_init__(self) -> None:
        _check_shape(self, "vertices", (None, 3))
        _check_shape(self, "normals", (len(self.vertices), 3))
        _check_shape(self, "faces", (None, 3))
        _check_shape(self, "uv", (len(self.vertices), 2))
        _check_shape(self, "texture", (None, None, 3))


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Dense points: (n, 3) metres in the cable frame, (n, 3) unit normals, (n, 3) uint8 RGB."""

    points: Array
    normals: Array
    colours: Picture

    def __post_init__(self) -> None:
        _check_shape(self, "points", (None, 3))
        _check_shape(self, "normals", (len(self.points), 3))
        _check_shape(self, "colours", (len(self.points), 3))


@dataclass(frozen=True, kw_only=True)
class ReportData:
    """Everything that report.json and report.html tell.  What a run does not have stays at its default.

    Attributes:
        name: name of the survey.
        length_m: path of the robot between the first and the last frame.
        blocks, stations: Table 1 and the sections.
        truth: true diameters for Table 2, empty where nobody knows them.
        lens_pictures, lens_effects: figures 2, 3 and 5, 6, for as many blocks as wanted.
        unrolled: the whole surface; block_unrolled: what each block contributed.
        profile, axis, mosaic, surface_prior, relief, mesh: see their types; mesh is that of the 3D view.
        timing_s: stage to seconds, in the order of the stages.
        peak_memory_mb: largest resident memory of the run.
        warnings: sentences for the person who reads the report.
        segments: of a long survey, that was worked off in several.
    """

    name: str
    length_m: float
    blocks: tuple[BlockSummary, ...]
    stations: tuple[StationResult, ...]
    truth: tuple[TruthStation, ...] = ()
    lens_pictures: tuple[LensPictures, ...] = ()
    lens_effects: tuple[LensEffect, ...] = ()
    unrolled: UnrolledPicture | None = None
    block_unrolled: tuple[UnrolledPicture, ...] = ()
    profile: DiameterProfile | None = None
    axis: AxisSummary | None = None
    mosaic: MosaicSummary | None = None
    surface_prior: SurfacePriorSummary | None = None
    relief: ReliefSummary | None = None
    mesh: Mesh | None = None
    timing_s: Mapping[str, float] = field(default_factory=dict)
    peak_memory_mb: float = float("nan")
    warnings: tuple[str, ...] = ()
    segments: tuple[SegmentSummary, ...] = ()
