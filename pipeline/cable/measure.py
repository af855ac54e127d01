"""Stage *measure*: diameters at the stations, with what they are worth.

Takes the placed blocks; gives at every station a section with its mean, smallest and largest diameter, the
standard deviation of the mean and the angle that was really seen, and the diameter and centre all along the
cable.  Circles and ellipses are fitted to distances, over the closed ring (design, fact 8), never
algebraically.
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.cable.closest_fit import PARAMETERS
from pipeline.cable.crop import Crop
from pipeline.cable.mosaic import Mosaic, MosaicBlock
from pipeline.cable.ring import Ring
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.fits.circle import Circle, fit_circle
from pipeline.core.fits.ellipse import fit_ellipse
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class MeasureOptions:
    """How sections are cut.

    Attributes:
        slice_mm: length of cable that a section averages over.
        profile_mm: distance between the sections of the profile along the cable.
        bin_deg: width of the bins around the cable that a section is averaged in.
        least_coverage_deg: a station seen over less than this is not measured.
        focal_relative_sigma: relative standard deviation of the focal length that calibrated lenses are
            given.
    """

    slice_mm: float = field(default=10.0, metadata={"above": 0.0})
    profile_mm: float = field(default=5.0, metadata={"above": 0.0})
    bin_deg: float = field(default=1.0, metadata={"above": 0.0, "maximum": 45.0})
    least_coverage_deg: float = field(default=90.0, metadata={"above": 0.0, "maximum": 360.0})
    focal_relative_sigma: float = field(default=0.0003, metadata={"minimum": 0.0})


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
        min_mm, max_mm: axes of the fitted ellipse.
        coverage_deg: angle around the cable that was seen.
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
    """

    sections: tuple[Section, ...]
    profile_y_m: Array
    profile_diameter_mm: Array
    profile_sigma_mm: Array
    profile_centre_mm: Array
    straightness_mm_per_m: float
    unmeasured: tuple[str, ...]


@dataclass(frozen=True)
class _Cut:
    """The binned points of all blocks in one slice: (k, 3) mm, weights, block of each, angle seen."""

    points: Array
    weights: Array
    block: Array
    coverage_deg: float


def measure_ring(
    blocks: tuple[MosaicBlock, ...],
    crops: tuple[Crop, ...],
    mosaic: Mosaic,
    ring: Ring,
    noise_mm: tuple[float, ...],
    focal_sigmas: tuple[float, ...],
    travel_share_sigma: float,
    stations: tuple[tuple[str, float], ...],
    travel_m: float,
    options: MeasureOptions,
    emit: Emit,
) -> Measurement:
    """Measure every station and the profile.

    Args:
        blocks, crops, mosaic, ring: the model.
        noise_mm: of a cell's radius, one a block.
        focal_sigmas: relative standard deviation of each block's focal length; 0 takes the option's.
        travel_share_sigma: relative standard deviation of the travel: the scale of everything.
        stations: names and positions, metres.
        travel_m: length of the profile.
        options: see there.
        emit: progress.

    Raises:
        StageError: not a single station was seen well enough.
    """
    cutter = _Cutter(blocks, crops, mosaic, ring, options)
    focal = np.array([s if s > 0 else options.focal_relative_sigma for s in focal_sigmas])
    spread = _Spread(mosaic, ring, np.asarray(noise_mm), focal, travel_share_sigma)
    sections, unmeasured = [], []
    for number, (name, position) in enumerate(stations):
        emit(Event(stage="measure", done=number, total=len(stations) + 1))
        cut = cutter.cut(position, options.slice_mm)
        if cut.coverage_deg < options.least_coverage_deg:
            unmeasured.append(name)
            continue
        sections.append(_section(name, position, cut, spread))
    if not sections:
        raise StageError(
            "measure",
            "no station was seen well enough to be measured",
            "place stations where the cameras passed",
        )
    profile_y = np.arange(0.0, travel_m + 1e-9, options.profile_mm / 1000)
    rows = [_profile_row(cutter.cut(y, options.profile_mm), spread, options) for y in profile_y]
    profile = np.array(rows)
    return Measurement(
        sections=tuple(sections),
        profile_y_m=profile_y,
        profile_diameter_mm=profile[:, 0],
        profile_sigma_mm=profile[:, 1],
        profile_centre_mm=profile[:, 2:],
        straightness_mm_per_m=_straightness(profile_y, profile[:, 2:]),
        unmeasured=tuple(unmeasured),
    )


class _Cutter:
    """Cuts slices out of the placed blocks."""

    def __init__(
        self,
        blocks: tuple[MosaicBlock, ...],
        crops: tuple[Crop, ...],
        mosaic: Mosaic,
        ring: Ring,
        options: MeasureOptions,
    ) -> None:
        self._blocks, self._crops, self._options = blocks, crops, options
        self._place = mosaic.placement
        self._align = ring.alignment

    def cut(self, y_m: float, length_mm: float) -> _Cut:
        """Bin all blocks' measured cells within ``length_mm`` about ``y_m``."""
        parts = [self._cut_block(n, y_m, length_mm) for n in range(len(self._blocks))]
        points, weights = (np.concatenate([p[i] for p in parts]) for i in (0, 1))
        block = np.concatenate([np.full(len(p[0]), n) for n, p in enumerate(parts)])
        seen = np.unique(np.floor(np.rad2deg(np.arctan2(-points[:, 2], points[:, 0]))))
        return _Cut(points, weights, block, float(len(seen)))

    def _cut_block(self, number: int, y_m: float, length_mm: float) -> tuple[Array, Array]:
        block, crop = self._blocks[number], self._crops[number]
        half = length_mm / 2000
        near = np.abs(block.surface.y_m - y_m) < half + 0.005
        rows = slice(int(np.argmax(near)), int(len(near) - np.argmax(near[::-1]))) if near.any() else slice(0)
        points = self._align.apply(self._place.apply(number, block.surface.points(rows)))
        use = crop.keep[rows] & block.surface.measured[rows] & (np.abs(points[..., 1] - y_m) < half)
        per_bin = max(
            round(np.deg2rad(self._options.bin_deg) / (block.surface.azimuth[1] - block.surface.azimuth[0])),
            1,
        )
        columns = use.shape[1] // per_bin
        shape = (use.shape[0], columns, per_bin)
        use = use[:, : columns * per_bin].reshape(shape)
        count = use.sum(axis=(0, 2))
        points = np.where(use[..., None], points[:, : columns * per_bin].reshape(*shape, 3), 0)
        mean = points.sum(axis=(0, 2)) / np.maximum(count, 1)[:, None]
        incidence = crop.incidence_deg[: columns * per_bin].reshape(columns, per_bin).mean(axis=1)
        filled = count > 0.2 * use.shape[0] * per_bin
        weight = np.cos(np.deg2rad(incidence)) ** 2 * count / max(use.shape[0] * per_bin, 1)
        return 1000 * mean[filled], weight[filled]


class _Spread:
    """Carries the blocks' uncertainty to a diameter."""

    def __init__(
        self, mosaic: Mosaic, ring: Ring, noise_mm: Array, focal_sigmas: Array, travel_share: float
    ) -> None:
        self._mosaic, self._ring, self._travel_share = mosaic, ring, travel_share
        self._noise_mm, self._focal = noise_mm, focal_sigmas

    def sigmas_mm(self, cut: _Cut, circle: Circle) -> tuple[float, float, float]:
        """Image, scale and lens part of the diameter's standard deviation, mm."""
        angle = np.arctan2(cut.points[:, 2] - circle.centre[1], cut.points[:, 0] - circle.centre[0])
        design = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
        weighted = design * cut.weights[:, None]
        gain = 2 * np.linalg.solve(weighted.T @ design, weighted.T)[0]  # of the diameter by radial shifts
        scale = float(np.hypot(self._scale(cut, gain, angle), 2 * circle.radius * self._travel_share))
        return self._image(cut, gain), scale, self._lens(cut, gain)

    def _image(self, cut: _Cut, gain: Array) -> float:
        """Windows of the sweep overlap their neighbours: bins are taken as alike over about three."""
        noise = self._noise_mm[cut.block]
        return float(np.sqrt(3 * np.sum((gain * noise) ** 2)))

    def _scale(self, cut: _Cut, gain: Array, angle: Array) -> float:
        placement, alignment = self._mosaic.placement, self._ring.alignment
        out = np.column_stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)]) @ alignment.rotation
        placed = (cut.points / 1000 - alignment.translation) @ alignment.rotation
        gradient = np.zeros(len(placement.origins) * PARAMETERS)
        for piece in range(len(placement.origins)):
            mine = cut.block == piece
            derivative = placement.derivative(piece, placed[mine])
            part = np.einsum("n,ni,nij->j", gain[mine], out[mine], derivative)
            gradient[piece * PARAMETERS : (piece + 1) * PARAMETERS] = 1000 * part
        return float(np.sqrt(gradient @ self._mosaic.covariance @ gradient))

    def _lens(self, cut: _Cut, gain: Array) -> float:
        """A focal length off by a share stretches a block in depth by the same share (design, fact 1)."""
        total = 0.0
        for piece in range(len(self._focal)):
            mine = cut.block == piece
            azimuth = np.arctan2(-cut.points[mine, 2], cut.points[mine, 0])
            middle = np.angle(np.exp(1j * azimuth).mean()) if mine.any() else 0.0
            depth = np.hypot(cut.points[mine, 0], cut.points[mine, 2]) * np.cos(azimuth - middle)
            rise = (depth - depth.mean()) if mine.any() else depth
            total += (self._focal[piece] * np.sum(gain[mine] * rise * np.cos(azimuth - middle))) ** 2
        return float(np.sqrt(total))


def _section(name: str, position: float, cut: _Cut, spread: _Spread) -> Section:
    flat = cut.points[:, [0, 2]]
    circle = fit_circle(flat, cut.weights)
    ellipse = fit_ellipse(flat, cut.weights, ovality_sigma=1.0)
    image, scale, lens = spread.sigmas_mm(cut, circle)
    return Section(
        name=name,
        position_m=position,
        diameter_mm=2 * circle.radius,
        sigma_mm=float(np.sqrt(image**2 + scale**2 + lens**2)),
        sigma_image_mm=image,
        sigma_scale_mm=scale,
        sigma_lens_mm=lens,
        min_mm=ellipse.smallest_diameter,
        max_mm=ellipse.largest_diameter,
        coverage_deg=cut.coverage_deg,
        centre_mm=circle.centre,
        points_mm=flat,
    )


def _profile_row(cut: _Cut, spread: _Spread, options: MeasureOptions) -> tuple[float, float, float, float]:
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
