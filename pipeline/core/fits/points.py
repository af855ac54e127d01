"""Checks that all fits make of their points and weights."""

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array


def checked(name: str, points: ArrayLike, weights: ArrayLike | None, dimensions: int) -> tuple[Array, Array]:
    """(n, d) finite points and (n,) weights, ones by default.

    Raises:
        StageError: wrong shape, not finite, or a negative weight.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != dimensions or not np.isfinite(array).all():
        raise StageError(
            "fit",
            f"points for a {name} must be finite and of shape (n, {dimensions}), these are {array.shape}",
            "leave out missing points",
        )
    weight = np.ones(len(array)) if weights is None else np.asarray(weights, dtype=float)
    if weight.shape != (len(array),) or not np.isfinite(weight).all() or (weight < 0).any():
        raise StageError(
            "fit",
            f"weights for a {name} must be ({len(array)},), finite and not negative",
            "give one weight a point",
        )
    return array, weight
