"""Joining rigid pieces by points held together and surfaces brought close.

An adjustment of independent models: every piece gets a similarity (seven parameters) that a prior, its POS,
holds softly; pairs of corresponding points and pairs of surface points and their feet on the neighbour pull
the pieces together.  (Ackermann, Ebner and Klein, "Block triangulation with independent models", 1973,
extended by surfaces.)
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from pipeline.core.rotations import cross_matrix, rotation_from_vector, vector_from_rotation
from pipeline.core.vocabulary import Array

PARAMETERS = 7


@dataclass(frozen=True, kw_only=True)
class Placement:
    """A similarity for each piece: X' = o + t + scale R (X - o).

    Attributes:
        origins: (b, 3) metres.
        rotations: (b, 3, 3).
        shifts: (b, 3) metres.
        scales: (b,).
    """

    origins: Array
    rotations: Array
    shifts: Array
    scales: Array

    def apply(self, piece: int, points: Array) -> Array:
        """Place points (..., 3) of one piece."""
        arms = (points - self.origins[piece]) @ self.rotations[piece].T
        return self.origins[piece] + self.shifts[piece] + self.scales[piece] * arms

    def undo(self, piece: int, points: Array) -> Array:
        """The inverse of :meth:`apply`."""
        arms = (points - self.origins[piece] - self.shifts[piece]) / self.scales[piece]
        return self.origins[piece] + arms @ self.rotations[piece]

    def derivative(self, piece: int, placed: Array) -> Array:
        """Of placed points (n, 3) by the piece's rotation vector, shift and log scale, (n, 3, 7)."""
        arms = placed - self.origins[piece] - self.shifts[piece]
        count = len(placed)
        return np.concatenate(
            [-cross_matrix(arms), np.broadcast_to(np.eye(3), (count, 3, 3)), arms[:, :, None]], axis=2
        )

    def moved(self, step: Array) -> "Placement":
        """After a step (7 b,) of rotation vectors, shifts and log scales."""
        steps = step.reshape(-1, PARAMETERS)
        return replace(
            self,
            rotations=rotation_from_vector(steps[:, :3]) @ self.rotations,
            shifts=self.shifts + steps[:, 3:6],
            scales=self.scales * np.exp(steps[:, 6]),
        )

    def deviation(self) -> Array:
        """From standing still, (b, 7)."""
        return np.concatenate(
            [vector_from_rotation(self.rotations), self.shifts, np.log(self.scales)[:, None]], axis=1
        )


@dataclass(frozen=True, kw_only=True)
class Tie:
    """Points of two pieces that belong together.

    Attributes:
        first, second: the pieces.
        points_first, points_second: (n, 3) as the pieces stand, metres.
        whitening: (n, 3, 3) turns a difference in the cable frame into standard deviations; a zero row leaves
            that direction free.
    """

    first: int
    second: int
    points_first: Array
    points_second: Array
    whitening: Array

    def residuals(self, placement: Placement) -> Array:
        """Whitened differences, (n, 3), in the size of the pieces themselves: divided by their mean scale.

        As placed, all differences would shrink with the whole model, and many ties with a little noise each
        would outweigh what is known of the scale.
        """
        return np.einsum("nij,nj->ni", self.whitening, self._gap(placement))

    def jacobian(self, placement: Placement) -> Array:
        """Of the residuals by the parameters of the first and the second piece, (n, 3, 14)."""
        sides = (self.first, self.points_first, 1), (self.second, self.points_second, -1)
        per_piece, mean = [], self._mean_scale(placement)
        for piece, points, sign in sides:
            derivative = sign * placement.derivative(piece, placement.apply(piece, points)) / mean
            derivative[:, :, 6] -= self._gap(placement) / 2
            per_piece.append(derivative)
        return self.whitening @ np.concatenate(per_piece, axis=2)

    def _gap(self, placement: Placement) -> Array:
        gap = placement.apply(self.first, self.points_first)
        return (gap - placement.apply(self.second, self.points_second)) / self._mean_scale(placement)

    def _mean_scale(self, placement: Placement) -> float:
        return float(np.sqrt(placement.scales[self.first] * placement.scales[self.second]))


@dataclass(frozen=True, kw_only=True)
class Fit:
    """The joined pieces.

    Attributes:
        placement: of each piece.
        covariance: (7 b, 7 b).
    """

    placement: Placement
    covariance: Array


def fit_pieces(
    start: Placement,
    information: Array,
    ties: Callable[[Placement], list[Tie]],
    iterations: int = 15,
) -> Fit:
    """Join the pieces by iteratively reweighted least squares (Cauchy, scale 3 sigma).

    Args:
        start: first guess; the pieces' own places are the prior.
        information: (7 b, 7 b) weight with which the pieces are held in their own places.
        ties: the ties for a placement; surface feet move with it.
        iterations: most steps.
    """
    placement = start
    for _ in range(iterations):
        matrix, right = _normals(placement, information, ties(placement))
        step = cho_solve(cho_factor(matrix), right)
        placement = placement.moved(step)
        if np.abs(step).max() < 1e-9:
            break
    matrix, _ = _normals(placement, information, ties(placement))
    return Fit(placement=placement, covariance=cho_solve(cho_factor(matrix), np.eye(len(matrix))))


def _normals(placement: Placement, information: Array, ties: list[Tie]) -> tuple[Array, Array]:
    matrix = information.copy()
    right = -information @ placement.deviation().ravel()
    for tie in ties:
        residuals = tie.residuals(placement)
        root = np.sqrt(1 / (1 + np.sum(residuals**2, axis=1) / 9))[:, None]
        jacobian = (root[..., None] * tie.jacobian(placement)).reshape(-1, 2 * PARAMETERS)
        columns = np.concatenate([n * PARAMETERS + np.arange(PARAMETERS) for n in (tie.first, tie.second)])
        matrix[np.ix_(columns, columns)] += jacobian.T @ jacobian
        right[columns] -= jacobian.T @ (root * residuals).ravel()
    return matrix, right
