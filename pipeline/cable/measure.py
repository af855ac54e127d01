"""Stage *measure*: diameters at the stations, with what they are worth, and the relief.

Takes the placed blocks; gives at every station a section with its mean, smallest and largest diameter, the
standard deviation of the mean and the angle that was really seen, the diameter and centre all along the
cable, and the relief: the base below what stands proud or is dented, and what does.  Circles and ellipses are
fitted to distances, over the closed ring (design, fact 8), never algebraically.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.cable.crop import Crop
from pipeline.cable.cutting import Cut, Cutter
from pipeline.cable.mosaic import Mosaic, MosaicBlock
from pipeline.cable.relief import Relief, ReliefOptions, find_relief
from pipeline.cable.ring import Ring
from pipeline.cable.uncertainty import Spread, Uncertainty
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.fits.circle import fit_circle
from pipeline.core.fits.ellipse import fit_ellipse
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """How sections are cut.

    Attributes:
        slice_mm: length of cable that a section averages over.
        longest_slice_mm: where little can be seen, a station's slice is lengthened up to this.
        wanted_coverage_deg: until the station is seen over this much.
        profile_mm: distance between the sections of the profile along the cable.
        bin_deg: width of the bins around the cable that a section is averaged in.
        least_coverage_deg: a station seen over less than this is not measured.
    """

    slice_mm: float = field(default=10.0, metadata={"above": 0.0})
    longest_slice_mm: float = field(default=40.0, metadata={"above": 0.0})
    wanted_coverage_deg: float = field(default=180.0, metadata={"above": 0.0, "maximum": 360.0})
    profile_mm: float = field(default=5.0, metadata={"above": 0.0})
    bin_deg: float = field(default=1.0, metadata={"above": 0.0, "maximum": 45.0})
    least_coverage_deg: float = field(default=90.0, metadata={"above": 0.0, "maximum": 360.0})


@dataclass(frozen=True, kw_only=True)
class Section:
    """One cross-section.

    Attributes:
        name: of the station.
        position_m: along the axis from the first frame.
        diameter_mm: mean, of the fitted circle.
        sigma_mm: standard deviation of the mean diameter.
        sigma_image_mm, sigma_scale_mm, sigma_lens_mm: its parts: noise of the surface; scale and joining of
            the blocks; focal length.
        base_diameter_mm, base_sigma_mm: mean diameter of the base section, without what stands proud or is
            dented, and its standard deviation; NaN where too little was seen.
        min_mm, max_mm: axes of the fitted ellipse.
        coverage_deg: angle around the cable that was seen there, however long a slice the fit had to take.
        centre_mm: (2,) x and z of the circle's centre.
        points_mm: (k, 2) x and z of the section.
    """

    name: str
    position_m: float
    diameter_mm: float
    sigma_mm: float
    sigma_image_mm: float
    sigma_scale_mm: float
    sigma_lens_mm: float
    base_diameter_mm: float
    base_sigma_mm: float
    min_mm: float
    max_mm: float
    coverage_deg: float
    centre_mm: Array
    points_mm: Array


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """All that was measured.

    Attributes:
        sections: one a station.
        profile_y_m: (n,) metres.
        profile_diameter_mm: (n,), NaN where too little was seen.
        profile_sigma_mm: (n,).
        profile_centre_mm: (n, 2) x and z of the centres.
        straightness_mm_per_m: largest distance of the centres from their best line, by length.
        unmeasured: names of the stations where too little was seen.
        relief: what stands out of the base surface.
    """

    sections: tuple[Section, ...]
    profile_y_m: Array
    profile_diameter_mm: Array
    profile_sigma_mm: Array
    profile_centre_mm: Array
    straightness_mm_per_m: float
    unmeasured: tuple[str, ...]
    relief: Relief


def measure_ring(
    blocks: tuple[MosaicBlock, ...],
    crops: tuple[Crop, ...],
    mosaic: Mosaic,
    ring: Ring,
    uncertainty: Uncertainty,
    stations: tuple[tuple[str, float], ...],
    travel_m: float,
    window_mm: float,
    options: MeasureOptions,
    relief_options: ReliefOptions,
    emit: Emit,
) -> Measurement:
    """Measure every station and the profile.

    Args:
        blocks, crops, mosaic, ring: the model.
        uncertainty: of what the diameters hang on.
        stations: names and positions, metres.
        travel_m: length of the profile.
        window_mm: side of the window that the surface was matched with.
        options, relief_options: see there.
        emit: progress.

    Raises:
        StageError: not a single station was seen well enough.
    """
    cutter = Cutter(blocks, crops, mosaic, ring, options.bin_deg)
    spread = Spread(mosaic, ring, uncertainty, options.bin_deg)
    radius_mm = 1000.0 * np.where(ring.measured, ring.radius_m, np.nan).astype(np.float64)
    with ThreadPoolExecutor(1) as beside:
        told = beside.submit(
            find_relief, ring.azimuth, ring.y_m, radius_mm, travel_m, window_mm, relief_options
        )
        profile_y, profile = _profile(cutter, spread, travel_m, options, part(emit, 0.0, 0.8))
        relief = told.result()
    sections, unmeasured = _sections(stations, cutter, spread, relief, options, part(emit, 0.8, 1.0))
    return Measurement(
        sections=sections,
        profile_y_m=profile_y,
        profile_diameter_mm=profile[:, 0],
        profile_sigma_mm=profile[:, 1],
        profile_centre_mm=profile[:, 2:],
        straightness_mm_per_m=_straightness(profile_y, profile[:, 2:]),
        unmeasured=unmeasured,
        relief=relief,
    )


def _sections(
    stations: tuple[tuple[str, float], ...],
    cutter: Cutter,
    spread: Spread,
    relief: Relief,
    options: MeasureOptions,
    emit: Emit,
) -> tuple[tuple[Section, ...], tuple[str, ...]]:
    """The sections of all stations that were seen well enough, and the names of the others."""
    sections, unmeasured = [], []
    for number, (name, position) in enumerate(stations):
        emit(Event(stage="measure", done=number, total=len(stations)))
        cut, here_deg = _station_cut(cutter, position, options)
        if cut.coverage_deg < options.least_coverage_deg:
            unmeasured.append(name)
            continue
        sections.append(replace(_section(name, position, cut, spread, relief), coverage_deg=here_deg))
    if not sections:
        raise StageError(
            "measure",
            "no station was seen well enough to be measured",
            "place stations where the cameras passed, and check angle_deg of every block",
        )
    return tuple(sections), tuple(unmeasured)


def _station_cut(cutter: Cutter, position_m: float, options: MeasureOptions) -> tuple[Cut, float]:
    """The shortest slice, doubled from the wanted one, in which enough of the girth was seen; else the last.

    And the angle that was seen in the wanted slice itself: that is what the station's coverage is.
    """
    length_mm = options.slice_mm
    cut = cutter.cut(position_m, length_mm)
    here_deg = cut.coverage_deg
    while cut.coverage_deg < options.wanted_coverage_deg and 2 * length_mm <= options.longest_slice_mm:
        length_mm *= 2
        cut = cutter.cut(position_m, length_mm)
    return cut, here_deg


def _section(name: str, position: float, cut: Cut, spread: Spread, relief: Relief) -> Section:
    flat = cut.points[:, [0, 2]]
    circle = fit_circle(flat, cut.weights)
    ellipse = fit_ellipse(flat, cut.weights, ovality_sigma=1.0)
    image, scale, lens = spread.sigmas_mm(cut, circle)
    base, base_noise = (
        float(np.interp(position, relief.y_m, along, left=np.nan, right=np.nan))
        for along in (relief.base_diameter_mm, relief.base_noise_mm)
    )
    return Section(
        name=name,
        position_m=position,
        diameter_mm=2 * circle.radius,
        sigma_mm=float(np.sqrt(image**2 + scale**2 + lens**2)),
        sigma_image_mm=image,
        sigma_scale_mm=scale,
        sigma_lens_mm=lens,
        base_diameter_mm=base,
        base_sigma_mm=float(np.sqrt(base_noise**2 + scale**2 + lens**2)),
        min_mm=ellipse.smallest_diameter,
        max_mm=ellipse.largest_diameter,
        coverage_deg=cut.coverage_deg,
        centre_mm=circle.centre,
        points_mm=flat,
    )


def _profile(
    cutter: Cutter, spread: Spread, travel_m: float, options: MeasureOptions, emit: Emit
) -> tuple[Array, Array]:
    """Places along the cable (n,), metres, and the rows of the profile there (n, 4)."""
    y_m, rows = np.arange(0.0, travel_m + 1e-9, options.profile_mm / 1000), []
    for number, y in enumerate(y_m):
        emit(Event(stage="measure", done=number, total=len(y_m)))
        rows.append(_profile_row(cutter.cut(y, options.profile_mm), spread, options))
    return y_m, np.array(rows)


def _profile_row(cut: Cut, spread: Spread, options: MeasureOptions) -> tuple[float, float, float, float]:
    """Diameter, its sigma, and the centre's x and z, mm."""
    if cut.coverage_deg < options.least_coverage_deg:
        return (np.nan, np.nan, np.nan, np.nan)
    circle = fit_circle(cut.points[:, [0, 2]], cut.weights)
    sigma = float(np.hypot(*spread.sigmas_mm(cut, circle)[:2]))
    return (2 * circle.radius, sigma, float(circle.centre[0]), float(circle.centre[1]))


def _straightness(y_m: Array, centres_mm: Array) -> float:
    good = np.isfinite(centres_mm[:, 0])
    if good.sum() < 3:
        return float("nan")
    design = np.column_stack([np.ones(good.sum()), y_m[good]])
    away = centres_mm[good] - design @ np.linalg.lstsq(design, centres_mm[good], rcond=None)[0]
    return float(np.hypot(away[:, 0], away[:, 1]).max() / np.ptp(y_m[good]))
