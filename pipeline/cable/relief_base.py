"""The base section of the cable all along it: the sheath without what stands proud of it or is dented.

Takes the map of radii about a straight axis; gives, as smooth functions of the position, the mean radius,
the centre and the ovality of the section below, and the map of heights over it.  Robust: a start by consensus
slab by slab (Fischler & Bolles 1981; scored by a truncated square, Torr & Zisserman 2000), then Tukey's
biweight over the whole cable.  Leaves out what the heights mean (:mod:`pipeline.cable.relief`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from pipeline.core.vocabulary import Array

BIN_MM = 2.0  # the base is fitted to medians of squares of this side
SLAB_MM = 10.0
HARMONICS = 5  # mean, two of the centre, two of the ovality
_SAMPLES = 300
_SECTORS = 6  # each sample takes one bin from each sector, so that none is ill-conditioned
_TUKEY = 4.685  # 95 % efficiency under normal noise
_ITERATIONS = 12
_LEAST_FILLED = 0.4  # of a slab's bins, that it may start a fit


@dataclass(frozen=True, kw_only=True)
class BaseSection:
    """The base all along the cable.

    Attributes:
        y_m: (n,) metres, of the map's rows.
        radius_mm: (n,) mean radius; NaN all through where too little was seen.
        centre_mm: (n, 2) x and z of its centre.
        ovality_mm: (n, 2) cosine and sine part of the radius's second harmonic.
        sigma_mm: (n,) standard deviation of the mean radius, from the map's noise alone.
        wave_mm: standard deviation of the map over areas of some 16 mm: what averaging does not remove.
    """

    y_m: Array
    radius_mm: Array
    centre_mm: Array
    ovality_mm: Array
    sigma_mm: Array
    wave_mm: float

    def heights_mm(self, azimuth: Array, radius_mm: Array) -> Array:
        """Heights over the base of cells at azimuths (m,) rad with radii (n, m) about the straight axis."""
        turn, radius = about_centre(azimuth[None, :], radius_mm, self.centre_mm[:, None])
        oval = self.ovality_mm[:, None]
        swing = oval[..., 0] * np.cos(2 * turn) + oval[..., 1] * np.sin(2 * turn)
        return np.asarray(radius - self.radius_mm[:, None] - swing)


def about_centre(azimuth: Array, radius_mm: Array, centre_mm: Array) -> tuple[Array, Array]:
    """Azimuth (rad) and radius of points seen from centres (..., 2), x and z, instead of from the axis."""
    x = radius_mm * np.cos(azimuth) - centre_mm[..., 0]
    z = -radius_mm * np.sin(azimuth) - centre_mm[..., 1]
    return np.arctan2(-z, x), np.hypot(x, z)


def fit_base(azimuth: Array, y_m: Array, radius_mm: Array, knots_mm: float, seed: int) -> BaseSection:
    """Fit the base to a map of radii.

    Args:
        azimuth: (m,) radians, evenly spaced, the full turn.
        y_m: (n,) metres, evenly spaced.
        radius_mm: (n, m), NaN where not measured.
        knots_mm: distance of the knots of the cubic splines along the cable.
        seed: of the samples for the start.
    """
    seen = np.isfinite(radius_mm).any()
    bins = _Bins.of(azimuth, y_m, radius_mm if seen else np.zeros_like(radius_mm))
    start = _start(bins, np.random.default_rng(seed)) if seen else None
    if start is None:
        nothing = np.full(len(y_m), np.nan)
        pair = np.full((len(y_m), 2), np.nan)
        return BaseSection(
            y_m=y_m, radius_mm=nothing, centre_mm=pair, ovality_mm=pair, sigma_mm=nothing, wave_mm=np.nan
        )
    basis = _Basis(y_m[0], y_m[-1], knots_mm / 1000)
    at_bins, at_rows = basis.at(bins.y_m), basis.at(y_m)
    centre, model = np.zeros((len(bins.y_m), 2)), start
    covariance, residual, weight = np.empty(0), np.empty(0), np.empty(0)
    for _ in range(_ITERATIONS):
        turn, radius = about_centre(bins.azimuth, bins.radius_mm, centre[:, None])
        design = _design(np.where(np.isnan(turn), bins.azimuth, turn))
        residual = radius - np.einsum("nmh,nh->nm", design, model)
        weight = _biweight(residual, np.maximum(_scale(residual), 0.005))
        control, covariance = _solve(at_bins, design, radius, weight)
        model = at_bins @ control
        centre = centre + model[:, 1:3] * [1.0, -1.0]
        # what the first harmonic says has moved into the centre
        model = model * [1.0, 0.0, 0.0, 1.0, 1.0]
    noise, wave = _noise(residual, weight)
    rows = at_rows @ control
    centres = np.column_stack([np.interp(y_m, bins.y_m, centre[:, axis]) for axis in (0, 1)])
    spread = np.einsum("nk,kl,nl->n", at_rows, covariance, at_rows)
    return BaseSection(
        y_m=y_m,
        radius_mm=rows[:, 0],
        centre_mm=centres,
        ovality_mm=rows[:, 3:5],
        sigma_mm=noise * np.sqrt(np.maximum(spread, 0)),
        wave_mm=wave,
    )


@dataclass(frozen=True, kw_only=True)
class _Bins:
    """Medians of squares: azimuth (1, q), y_m (p,), radius_mm (p, q)."""

    azimuth: Array
    y_m: Array
    radius_mm: Array

    @staticmethod
    def of(azimuth: Array, y_m: Array, radius_mm: Array) -> "_Bins":
        around_mm = max(float(np.nanmedian(radius_mm)), 1.0) * (azimuth[1] - azimuth[0])
        along_mm = 1000 * (y_m[1] - y_m[0])
        side = max(round(BIN_MM / along_mm), 1), max(round(BIN_MM / around_mm), 1)
        p, q = len(y_m) // side[0], len(azimuth) // side[1]
        cut = radius_mm[: p * side[0], : q * side[1]].reshape(p, side[0], q, side[1])
        cells = cut.transpose(0, 2, 1, 3).reshape(p, q, -1)
        few = np.isfinite(cells).sum(axis=2) < max(cells.shape[2] // 4, 1)
        cells = np.where(few[..., None], 0.0, cells)
        middle = np.where(few, np.nan, np.nanmedian(cells, axis=2))
        return _Bins(
            azimuth=azimuth[: q * side[1]].reshape(q, -1).mean(axis=1)[None],
            y_m=y_m[: p * side[0]].reshape(p, -1).mean(axis=1),
            radius_mm=middle,
        )


class _Basis:
    """Cubic B-splines with even knots."""

    def __init__(self, first: float, last: float, step: float) -> None:
        spans = max(round((last - first) / step), 1)
        inner = np.linspace(first, last, spans + 1)
        self._knots = np.concatenate([[first] * 3, inner, [last] * 3])

    def at(self, y_m: Array) -> Array:
        """(n, k) values of the k splines."""
        inside = np.clip(y_m, self._knots[0], self._knots[-1])
        return BSpline.design_matrix(inside, self._knots, 3).toarray()


def _design(azimuth: Array) -> Array:
    one = np.ones_like(azimuth)
    parts = [one, np.cos(azimuth), np.sin(azimuth), np.cos(2 * azimuth), np.sin(2 * azimuth)]
    return np.stack(parts, axis=-1)


def _scale(residual: Array) -> float:
    """Standard deviation of the bulk."""
    return float(1.4826 * np.nanmedian(np.abs(residual)))


def _biweight(residual: Array, scale: float) -> Array:
    part = np.nan_to_num(residual / (_TUKEY * scale), nan=2.0)
    return np.where(np.abs(part) < 1, (1 - part**2) ** 2, 0.0)


def _solve(basis: Array, design: Array, radius: Array, weight: Array) -> tuple[Array, Array]:
    """Control values (k, 5) of the splines, and the covariance (k, k) of those of the mean, for unit noise.

    A whisper of second differences carries the splines over gaps.
    """
    known = np.where(weight > 0, radius, 0.0)
    square = np.einsum("nmh,nm,nmg->nhg", design, weight, design)
    right = np.einsum("nmh,nm,nm->nh", design, weight, known)
    k = basis.shape[1]
    pairs = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
    normal = (pairs.T @ square.reshape(len(square), -1)).reshape(k, k, HARMONICS, HARMONICS)
    normal = normal.transpose(0, 2, 1, 3).reshape(k * HARMONICS, -1)
    bend = np.diff(np.eye(k), n=2, axis=0) if k > 2 else np.zeros((0, k))
    stiff = 1e-3 * np.trace(normal) / len(normal)
    normal += np.kron(stiff * bend.T @ bend + 1e-6 * stiff * np.eye(k), np.eye(HARMONICS))
    inverse = np.linalg.inv(normal)
    control = inverse @ np.einsum("nk,nh->kh", basis, right).ravel()
    return control.reshape(k, HARMONICS), inverse[::HARMONICS, ::HARMONICS]


def _start(bins: _Bins, random: np.random.Generator) -> Array | None:
    """First guess (p, 5) of the coefficients at the bins' rows, or None where too little was seen."""
    p = len(bins.y_m)
    rows = max(round(SLAB_MM / BIN_MM), 1)
    firsts = range(0, p, rows)
    slabs = [bins.radius_mm[f : f + rows] for f in firsts]
    found = np.array([_consensus(slab, bins.azimuth[0], random) for slab in slabs])
    good = np.isfinite(found[:, 0])
    if not good.any():
        return None
    middle = np.array([bins.y_m[f : f + rows].mean() for f in firsts])
    steady = np.array([np.median(found[good][max(i - 2, 0) : i + 3], axis=0) for i in range(good.sum())])
    return np.column_stack([np.interp(bins.y_m, middle[good], steady[:, h]) for h in range(HARMONICS)])


def _consensus(slab: Array, azimuth: Array, random: np.random.Generator) -> Array:
    """The section (5,) that most of a slab agrees to; NaN where less than enough of it was seen."""
    nothing = np.full(HARMONICS, np.nan)
    filled = np.isfinite(slab).any(axis=0)
    sector = np.arange(len(azimuth)) * _SECTORS // len(azimuth)
    groups = [np.flatnonzero(filled & (sector == s)) for s in range(_SECTORS)]
    if filled.mean() < _LEAST_FILLED or min(len(g) for g in groups) == 0:
        return nothing
    values = np.zeros(len(azimuth))
    values[filled] = np.nanmedian(slab[:, filled], axis=0)
    design = _design(azimuth)
    chosen = np.stack([random.choice(g, _SAMPLES) for g in groups], axis=1)
    tries = np.einsum("shk,sk->sh", np.linalg.pinv(design[chosen]), values[chosen])
    away = np.abs(tries @ design[filled].T - values[filled])
    bulk = 1.4826 * np.median(away, axis=1).min()
    score = np.minimum(away / max(3 * bulk, 0.03), 1.0) ** 2
    return np.asarray(tries[int(score.sum(axis=1).argmin())])


def _noise(residual: Array, weight: Array) -> tuple[float, float]:
    """Noise of a bin as large areas see it, and the standard deviation over those areas, mm.

    Windows of the dense step overlap and seams run along the cable: means of 8 x 8 bins scatter more than
    independent bins would let them.
    """
    side = 8
    p, q = residual.shape[0] // side, residual.shape[1] // side
    if not p or not q:
        scale = _scale(residual)
        return scale * side, scale
    shape = (p, side, q, side)
    share = np.where(weight > 0.2, 1.0, 0.0)[: p * side, : q * side].reshape(shape)
    total = np.nan_to_num(residual[: p * side, : q * side]).reshape(shape) * share
    count = share.sum(axis=(1, 3))
    full = count > 0.5 * side * side
    if not full.any():
        scale = _scale(residual)
        return scale * side, scale
    wave = _scale(total.sum(axis=(1, 3))[full] / count[full])
    return wave * side, wave
