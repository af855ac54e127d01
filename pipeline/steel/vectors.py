"""Products of many short vectors.

numpy's sum over an axis of two or three is ten times slower than adding the columns, to the same digits.
"""

import numpy as np

from pipeline.core.vocabulary import Array


def dots(a: Array, b: Array) -> Array:
    """Scalar products (...) of vectors (..., 2) or (..., 3)."""
    total = a[..., 0] * b[..., 0]
    for k in range(1, a.shape[-1]):
        total = total + a[..., k] * b[..., k]
    return np.asarray(total)


def lengths(a: Array) -> Array:
    """Lengths (...) of vectors (..., 2) or (..., 3)."""
    return np.asarray(np.sqrt(dots(a, a)))
