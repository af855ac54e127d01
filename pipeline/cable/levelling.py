"""Places of images along the cable from the shifts between them, as in a levelling net.

Takes shifts, some of them contradictory; gives places by robust least squares.  Leaves out how the shifts are
found (:mod:`pipeline.cable.sift_match`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Net:
    """Shifts between images: image ``second[k]`` lies ``along_m[k]`` further than ``first[k]``.

    Attributes:
        first, second: (n,) int64 image numbers.
        along_m: (n,) metres.
        sigma_m: (n,) their standard deviations.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    along_m: Array
    sigma_m: Array

    def part(self, chosen: NDArray[np.bool_]) -> "Net":
        """Some of the shifts."""
        return Net(
            first=self.first[chosen],
            second=self.second[chosen],
            along_m=self.along_m[chosen],
            sigma_m=self.sigma_m[chosen],
        )

    def residuals(self, places_m: Array) -> Array:
        """(n,) what is left of the shifts with the images at these places."""
        return places_m[self.second] - places_m[self.first] - self.along_m


def net_places(net: Net, gross_m: float, names: Sequence[str], block: str) -> Array:
    """Places of the images along the cable, (n,) metres, up to a common shift.

    Least sum of absolute residuals first, which contradictory shifts do not move as long as they are the
    fewer, then without them least squares (Huber's loss is convex: no start is needed).

    Args:
        net: shifts between images.
        gross_m: shifts further off than this are contradictory.
        names: of the images, for messages.
        block: its name, for messages.

    Raises:
        StageError: an image or a group of images is not tied to the others.
    """
    _check_tied(net, names, block)
    weight = net.sigma_m**-2.0
    places_m = _adjust(net, weight, len(names))
    for _ in range(30):
        off = np.abs(net.residuals(places_m)) / net.sigma_m
        places_m = _adjust(net, weight / np.maximum(off, 0.1), len(names))
    net = net.part(np.abs(net.residuals(places_m)) < gross_m)
    _check_tied(net, names, block)
    return _adjust(net, net.sigma_m**-2.0, len(names))


def _adjust(net: Net, weight: Array, count: int) -> Array:
    """Weighted least squares; the mean place is zero."""
    normal, right = np.full((count, count), weight.mean()), np.zeros(count)
    for i, j, sign in (
        (net.first, net.first, 1),
        (net.second, net.second, 1),
        (net.first, net.second, -1),
        (net.second, net.first, -1),
    ):
        np.add.at(normal, (i, j), sign * weight)
    np.add.at(right, net.second, weight * net.along_m)
    np.add.at(right, net.first, -weight * net.along_m)
    return np.linalg.solve(normal, right)


def _check_tied(net: Net, names: Sequence[str], block: str) -> None:
    """Refuse images that no chain of shifts ties to the others."""
    graph = coo_array((np.ones(len(net.first)), (net.first, net.second)), shape=(len(names),) * 2)
    groups, group = connected_components(graph, directed=False)
    if groups == 1:
        return
    sizes = np.bincount(group)
    lost = np.flatnonzero(group != np.argmax(sizes))
    listed = ", ".join(names[k] for k in lost[:3]) + (", ..." if len(lost) > 3 else "")
    raise StageError(
        "frames",
        f"{block}: {listed} cannot be tied to the other images, for they share too few marks of the surface",
        "take them out of the folder, or add images of the way between",
    )
