"""How well the joint adjustment knows every block's strip of surface, place by place along the cable.

Takes the adjusted ring; gives the covariance of how the strips lie: against each other, and each in itself.
What a diameter makes of it is asked only when the section is there: a circle through the whole girth hardly
feels that two strips have turned against each other, one with a gap feels it several times as much, and how
the fit weighs its points counts as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.bundle import BundleResult
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.normals import gradient_through_points
from pipeline.core.rig import Observations
from pipeline.core.vocabulary import Array

SECTION_STEP_M = 0.02
"""Distance of the places, and half of the length of cable whose tie points tell of one."""
SHAPES = 5
"""Growth, two shifts, and the two ways in which a strip is bent in its section."""
LEAST_POINTS = 30
"""Where a strip has fewer tie points than this, those of more cable are taken."""


@dataclass(frozen=True, kw_only=True)
class RingSigmas:
    """From the joint adjustment: covariance of the strips' places, travel taken as exact.

    Attributes:
        y_m: (n,) places along the cable.
        azimuth: (b,) of the blocks' cameras, radians.
        strips_mm2: (n, 5 b, 5 b) covariance of the coefficients of :func:`shapes`, block after block: how far
            the strip stands out, mm.
        lens_mm2: (n, 5 b, 5 b) what would go if the lenses were known.
    """

    y_m: Array
    azimuth: Array
    strips_mm2: Array
    lens_mm2: Array

    def sigmas_mm(self, y_m: float, block: Array, azimuth: Array, gain: Array) -> tuple[float, float]:
        """Standard deviation of a linear function of the surface, and the lenses' share of it, mm.

        Args:
            y_m: place along the cable.
            block, azimuth: (k,) of points of the section, radians.
            gain: (k,) what the function changes by when a point moves outwards.
        """
        towards = np.zeros((len(self.azimuth), SHAPES))
        for number, middle in enumerate(self.azimuth):
            mine = block == number
            towards[number] = gain[mine] @ shapes(azimuth[mine] - middle)
        flat = towards.ravel()
        whole, lens = (
            float(np.interp(y_m, self.y_m, np.einsum("i,nij,j->n", flat, part, flat)))
            for part in (self.strips_mm2, self.lens_mm2)
        )
        return float(np.sqrt(max(whole, 0.0))), float(np.sqrt(max(min(lens, whole), 0.0)))


def shapes(turned: Array) -> Array:
    """(k, 5) outward moves of points at angles (k,) from the middle of their strip."""
    return np.stack(
        [np.ones_like(turned), np.cos(turned), np.sin(turned), np.cos(2 * turned), np.sin(2 * turned)],
        axis=-1,
    )


def ring_sigmas(result: BundleResult, measured: Observations, azimuth_deg: Array, y_m: Array) -> RingSigmas:
    """Carry the covariance of orientations and lenses to the strips.

    Args:
        result: the adjusted ring.
        measured: the tie points' measurements, without the marks that two blocks share.
        azimuth_deg: (b,) of the blocks' cameras.
        y_m: (frames,) the body's places.
    """
    middles = np.deg2rad(azimuth_deg)
    places = np.arange(y_m.min(), y_m.max() + 1e-9, SECTION_STEP_M)
    strips = _strips(result, measured, middles)
    lenses = _free_lenses(result)
    known = np.linalg.inv(result.covariance[np.ix_(lenses, lenses)])
    size = SHAPES * len(middles)
    total, lens = np.zeros((2, len(places), size, size))
    for number, place in enumerate(places):
        gains = np.zeros((size, len(result.rig.points), 3))
        for block, (rows, turned, out) in enumerate(strips):
            near = _near(result.rig.points[rows, 1], place)
            found = np.linalg.pinv(shapes(turned[near])) if len(near) else np.zeros((SHAPES, 0))
            gains[SHAPES * block : SHAPES * (block + 1), rows[near]] = found[..., None] * out[near]
        gradient = 1000 * gradient_through_points(result.normals, gains)
        total[number] = gradient @ result.covariance @ gradient.T
        towards = gradient @ result.covariance[:, lenses]
        lens[number] = towards @ known @ towards.T
    return RingSigmas(y_m=places, azimuth=middles, strips_mm2=total, lens_mm2=lens)


def _strips(
    result: BundleResult, measured: Observations, middles: Array
) -> list[tuple[NDArray[np.int64], Array, Array]]:
    """Each block's tie points: their rows, angles from its middle, and unit vectors away from the axis."""
    points = result.rig.points
    cylinder = fit_cylinder(points, direction=(0.0, 1.0, 0.0))
    away = points - cylinder.axis_at(points[:, 1] - cylinder.point[1])
    azimuth = np.arctan2(-away[:, 2], away[:, 0])
    out = np.stack([np.cos(azimuth), np.zeros_like(azimuth), -np.sin(azimuth)], axis=1)
    strips = []
    for block, middle in enumerate(middles):
        rows = np.unique(measured.point[measured.camera == block])
        strips.append((rows, np.angle(np.exp(1j * (azimuth[rows] - middle))), out[rows]))
    return strips


def _near(along_m: Array, place_m: float) -> NDArray[np.int64]:
    """The points that tell of a place: those around it, of more cable where there are few."""
    distance = np.abs(along_m - place_m)
    few = min(LEAST_POINTS, len(distance))
    reach = max(SECTION_STEP_M, float(np.partition(distance, few - 1)[few - 1])) if few else 0.0
    return np.flatnonzero(distance <= reach)


def _free_lenses(result: BundleResult) -> NDArray[np.int64]:
    """The lens unknowns that are not held."""
    lenses = result.rig.lens_unknowns
    return lenses.start + np.flatnonzero(np.diag(result.covariance)[lenses] > 0)
