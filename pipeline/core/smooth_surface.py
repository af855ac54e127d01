"""A locally smooth cable surface, and the weak pseudo-observations that tie points lie near it.

Takes tie points; gives each one's distance from a surface whose axis is a low-order curve along y, whose
radius is free at every place along the cable, and whose sections may be oval; with the derivatives that the
adjustment needs.  The surface has no stated size: all its parameters are unknowns of the adjustment, so it
can neither widen nor narrow a section, only say that the strips of one section belong to one curve.  The
adjustment itself is in :mod:`pipeline.core.bundle`.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from pipeline.core.axis import AxisCurve
from pipeline.core.normals import PointEquations
from pipeline.core.vocabulary import Array

AXIS_COEFFICIENTS = 4
"""Of each of x and z along y: bows and S-bends of the cable."""

NODE_STEP_M = 0.02
"""Distance of the places where the radius is an unknown of its own; linear between them."""

BEND_SIGMA_M = 5e-3
"""Of the radius at a node against the mean of its neighbours': keeps a stretch without points determined."""

OVALITY_SIGMA_M = 5e-3
"""Of the oval's two amplitudes: keeps them determined where a single strip is seen."""


@dataclass(frozen=True, kw_only=True)
class SmoothSurface:
    """The surface (azimuth a, position y): axis(y) + (radius(y) + oval(a)) (cos a, 0, -sin a).

    Attributes:
        nodes_y_m: (k,) places of the radius nodes, evenly spaced.
        values: (p,) metres: 4 coefficients of the axis' x in powers of (y - middle) / half length, 4 of its
            z, the k radii, amplitudes of cos 2a and sin 2a.
    """

    nodes_y_m: Array
    values: Array

    @property
    def axis(self) -> AxisCurve:
        """The axis as a curve in y."""
        middle, half = self._scaling()
        rows = self.values[: 2 * AXIS_COEFFICIENTS].reshape(2, -1)
        return AxisCurve(origin_y_m=middle, coefficients=rows / half ** np.arange(AXIS_COEFFICIENTS))

    @property
    def radii_m(self) -> Array:
        """(k,) at the nodes."""
        return self.values[2 * AXIS_COEFFICIENTS : -2]

    def moved(self, step: Array) -> Self:
        """The surface with its values (p,) changed by ``step``."""
        return replace(self, values=self.values + step)

    def distances(self, points: Array) -> tuple[Array, Array, Array]:
        """Radial distances of points (m, 3), positive outside, and their derivatives.

        Returns:
            (m,) metres, (m, 3) by the point, (m, p) by the values.
        """
        middle, half = self._scaling()
        t = (points[:, 1] - middle) / half
        powers = t[:, None] ** np.arange(AXIS_COEFFICIENTS)
        slopes = np.arange(AXIS_COEFFICIENTS) * t[:, None] ** np.maximum(np.arange(AXIS_COEFFICIENTS) - 1, 0)
        coefficients = self.values[: 2 * AXIS_COEFFICIENTS].reshape(2, -1)
        away = points[:, [0, 2]] - powers @ coefficients.T
        length = np.hypot(away[:, 0], away[:, 1])
        out = away / length[:, None]
        azimuth = np.arctan2(-away[:, 1], away[:, 0])
        waves = np.stack([np.cos(2 * azimuth), np.sin(2 * azimuth)], axis=1)
        hats, hat_slopes = self._hats(points[:, 1])
        oval = self.values[-2:]
        turning = (waves @ [2 * oval[1], -2 * oval[0]]) / length  # d oval / d azimuth, by length
        by_away = out - turning[:, None] * np.stack([out[:, 1], -out[:, 0]], axis=1)
        along = -np.sum(by_away * (slopes @ coefficients.T) / half, axis=1) - hat_slopes @ self.radii_m
        by_point = np.stack([by_away[:, 0], along, by_away[:, 1]], axis=1)
        by_axis = -by_away[:, :, None] * powers[:, None, :]
        by_values = np.concatenate([by_axis.reshape(len(points), -1), -hats, -waves], axis=1)
        return length - hats @ self.radii_m - waves @ oval, by_point, by_values

    def information(self) -> Array:
        """(p, p) of what is said of the values themselves: next to nothing, see BEND_ and OVALITY_SIGMA_M."""
        matrix = np.zeros((len(self.values), len(self.values)))
        bends = np.diff(np.eye(len(self.nodes_y_m)), 2, axis=0) / (2 * BEND_SIGMA_M)
        nodes = slice(2 * AXIS_COEFFICIENTS, -2)
        matrix[nodes, nodes] = bends.T @ bends
        matrix[[-2, -1], [-2, -1]] = 1 / OVALITY_SIGMA_M**2
        return matrix

    def _scaling(self) -> tuple[float, float]:
        first, last = float(self.nodes_y_m[0]), float(self.nodes_y_m[-1])
        return (first + last) / 2, (last - first) / 2

    def _hats(self, y_m: Array) -> tuple[Array, Array]:
        """(m, k) each node's share in the radius at y (m,), and its derivative by y."""
        step = self.nodes_y_m[1] - self.nodes_y_m[0]
        place = (y_m - self.nodes_y_m[0]) / step
        inside = np.clip(place, 0, len(self.nodes_y_m) - 1)
        left = np.minimum(inside.astype(int), len(self.nodes_y_m) - 2)
        rows, share = np.arange(len(y_m)), inside - left
        hats, slopes = np.zeros((2, len(y_m), len(self.nodes_y_m)))
        hats[rows, left], hats[rows, left + 1] = 1 - share, share
        rise = np.where(place == inside, 1 / step, 0.0)
        slopes[rows, left], slopes[rows, left + 1] = -rise, rise
        return hats, slopes


@dataclass(frozen=True, kw_only=True)
class SurfacePrior:
    """What is said of the tie points: they lie near one smooth surface.

    Attributes:
        surface: as estimated so far.
        sigmas_m: (m,) of each point's distance; inf says nothing of it.
        loss_scale_m: distance at which the Cauchy loss halves the weight: fillets and defects.
    """

    surface: SmoothSurface
    sigmas_m: Array
    loss_scale_m: float

    def moved(self, step: Array) -> Self:
        """With the surface's values changed by ``step`` (p,)."""
        return replace(self, surface=self.surface.moved(step))

    def weights(self, distances: Array) -> Array:
        """(m,) weights in 1/m^2 that the loss leaves to points at these distances."""
        return 1 / self.sigmas_m**2 / (1 + (distances / self.loss_scale_m) ** 2)

    def equations(self, points: Array) -> PointEquations:
        """The pseudo-observations at points (m, 3), weighted; and the surface's own information."""
        distances, by_point, by_values = self.surface.distances(points)
        roots = np.sqrt(self.weights(distances))
        information = self.surface.information()
        return PointEquations(
            residuals=-distances * roots,
            points=by_point * roots[:, None],
            shared=by_values * roots[:, None],
            information=information,
            right=-information @ self.surface.values,
        )

    def cost(self, points: Array) -> float:
        """What the pseudo-observations add to the cost."""
        distances, _, _ = self.surface.distances(points)
        share = (self.loss_scale_m / self.sigmas_m) ** 2
        own = self.surface.values @ self.surface.information() @ self.surface.values
        return float(share @ np.log1p((distances / self.loss_scale_m) ** 2) + own)


def surface_prior(points: Array, sigma_m: float, loss_scale_m: float, patch_m: float) -> SurfacePrior:
    """The prior for tie points, its surface fitted to them as they stand.

    What a real surface does to one point it does to its neighbours: the points of one patch together count
    as one piece of evidence, or thousands of points would make a weak prior a hard one.

    Args:
        points: (m, 3) metres.
        sigma_m: by how much the cable's surface departs from a smooth one.
        loss_scale_m: see :class:`SurfacePrior`.
        patch_m: side of the patches over which these departures are alike.
    """
    first, last = points[:, 1].min(), points[:, 1].max()
    nodes = np.linspace(first, last, max(round((last - first) / NODE_STEP_M), 1) + 1)
    values = np.zeros(2 * AXIS_COEFFICIENTS + len(nodes) + 2)
    surface = SmoothSurface(nodes_y_m=nodes, values=values)
    values[[0, AXIS_COEFFICIENTS]] = np.median(points[:, [0, 2]], axis=0)
    values[2 * AXIS_COEFFICIENTS : -2] = np.median(surface.distances(points)[0])
    sigmas = sigma_m * np.sqrt(_neighbours(surface, points, patch_m))
    for scale in (*np.geomspace(0.02, loss_scale_m, 8), *[loss_scale_m] * 4):
        prior = SurfacePrior(surface=surface, sigmas_m=sigmas, loss_scale_m=float(scale))
        surface = surface.moved(_fitted(prior, points))
    return SurfacePrior(surface=surface, sigmas_m=sigmas, loss_scale_m=loss_scale_m)


def _fitted(prior: SurfacePrior, points: Array) -> Array:
    """One Gauss-Newton step (p,) of the surface with the points held."""
    said = prior.equations(points)
    normal = said.shared.T @ said.shared + said.information
    return np.linalg.lstsq(normal, said.shared.T @ said.residuals + said.right, rcond=None)[0]


def _neighbours(surface: SmoothSurface, points: Array, patch_m: float) -> Array:
    """(m,) number of points in each one's patch."""
    azimuth, y_m, radius = surface.axis.unroll(points)
    around = np.floor((azimuth + np.pi) / patch_m * np.median(radius)).astype(int)
    patch = np.floor((y_m - y_m.min()) / patch_m).astype(int) * (around.max() + 1) + around
    return np.bincount(patch)[patch].astype(float)
