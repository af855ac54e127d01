"""What a diameter is worth: everything it hangs on, carried through the section to its standard deviation.

Takes a slice, its circle and what is known of noise, places, lenses and travel; gives three parts: image,
scale, lens.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.cable.closest_fit import PARAMETERS
from pipeline.cable.cutting import Cut
from pipeline.cable.joint_sections import RingSigmas
from pipeline.cable.mosaic import Mosaic
from pipeline.cable.ring import Ring
from pipeline.core.fits.circle import Circle
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Uncertainty:
    """What the diameters hang on.

    Attributes:
        noise_mm: of a cell's radius, one a block.
        window_mm: side of the window that a cell was matched in, one a block: noise is alike over it.
        focal_shares: relative standard deviation of each block's focal length.
        travel_share: relative standard deviation of the travel: the scale of everything.
        together: from the joint adjustment; None where the blocks were adjusted alone.
    """

    noise_mm: tuple[float, ...]
    window_mm: tuple[float, ...]
    focal_shares: tuple[float, ...]
    travel_share: float
    together: RingSigmas | None


def mean_over(length_mm: float, window_mm: Array) -> Array:
    """Variance of the mean over a length, as a share of that of a single cell matched in such a window (k,).

    Two cells share the part of their windows that overlaps, so their correlation falls evenly to zero over a
    window (measured on the radius maps: 0.54 half a window apart, nothing left at one), and the mean over a
    length has the variance of that triangle (Papoulis and Pillai, *Probability, Random Variables and
    Stochastic Processes*, 4th edition, 2002, section 12-1, time averages).
    """
    share = np.maximum(window_mm, 1e-9) / length_mm
    return np.where(share < 1, share * (1 - share / 3), 1 - 1 / (3 * np.maximum(share, 1)))


class Spread:
    """Carries the blocks' uncertainty to a diameter, of slices cut into bins of ``bin_deg``."""

    def __init__(self, mosaic: Mosaic, ring: Ring, uncertainty: Uncertainty, bin_deg: float) -> None:
        self._mosaic, self._ring, self._known = mosaic, ring, uncertainty
        self._noise_mm, self._window_mm = np.asarray(uncertainty.noise_mm), np.asarray(uncertainty.window_mm)
        self._bin_deg = bin_deg
        self._focal = np.asarray(uncertainty.focal_shares)

    def sigmas_mm(self, cut: Cut, circle: Circle) -> tuple[float, float, float]:
        """Image, scale and lens part of the diameter's standard deviation, mm."""
        angle = np.arctan2(cut.points[:, 2] - circle.centre[1], cut.points[:, 0] - circle.centre[0])
        design = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
        weighted = design * cut.weights[:, None]
        gain = 2 * np.linalg.solve(weighted.T @ design, weighted.T)[0]  # of the diameter by radial shifts
        image, travel = self._image(cut, gain, circle.radius), 2 * circle.radius * self._known.travel_share
        together = self._known.together
        if together is None:
            return image, float(np.hypot(self._scale(cut, gain, angle), travel)), self._lens(cut, gain)
        y_m = float(cut.points[:, 1].mean()) / 1000
        whole, lens = together.sigmas_mm(y_m, cut.block, -angle, gain)
        return image, float(np.sqrt(max(whole**2 - lens**2, 0.0) + travel**2)), lens

    def _image(self, cut: Cut, gain: Array, radius_mm: float) -> float:
        """Windows of the sweep overlap their neighbours: so many bins as a window covers are alike.

        Around the cable every bin is one of those; along it a bin is already the mean over the slice.
        """
        window_mm = self._window_mm[cut.block]
        alike = np.maximum(window_mm / (np.deg2rad(self._bin_deg) * radius_mm), 1.0)
        noise = self._noise_mm[cut.block] * np.sqrt(mean_over(cut.length_mm, window_mm))
        return float(np.sqrt(np.sum(alike * (gain * noise) ** 2)))

    def _scale(self, cut: Cut, gain: Array, angle: Array) -> float:
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

    def _lens(self, cut: Cut, gain: Array) -> float:
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
