"""A strip's cells in one frame as their radius changes, and how alike two frames show them.

Takes a view of the cells, frames ready to be compared and candidate radii; gives the frame's values at the
cells, and the correlation of every window.  Several candidates are looked up at once.
"""

import cv2
import numpy as np

from pipeline.cable.surface_view import Image, SurfaceView, sample
from pipeline.core.vocabulary import Array


class CellPath:
    """The way of every cell through one frame as its radius changes: a parabola through three places.

    Exact projections cost more than all the rest of the sweep; over 5 mm at 245 mm the parabola is off by
    less than 0.01 px, over 1 mm by less than 0.0001 px.  ``aside`` takes the cells sideways as they rise.
    """

    def __init__(self, view: SurfaceView, start_m: Image, reach_m: float, aside: Array | None) -> None:
        self.frame = view.frame
        self._view, reach = view, np.float32(reach_m)
        places = np.array([-reach, 0, reach], dtype=np.float32)[:, None, None]
        beside = None if aside is None else places * view.turned(aside)[:, None]
        pixels = view.pixels(start_m + places, beside)
        self._start = pixels[0][1], pixels[1][1]
        self._terms = [
            (here, (after - before) / (2 * reach), (after + before - 2 * here) / (2 * reach**2))
            for before, here, after in pixels
        ]

    def visible(self, window: int) -> Image:
        """1 where the whole comparison window about the start lies in the frame, else 0."""
        return self._view.visible(self._start, window)

    def sample(self, image: Image, offsets_m: Array) -> Image:
        """The frame's values at the cells when their radius is larger by each of k offsets, (k, n, m)."""
        offsets = offsets_m.astype(np.float32)[:, None, None]
        column, row = (_flat(_parabola(offsets, *terms)) for terms in self._terms)
        return sample(image, (column, row)).reshape(len(offsets), *self._start[0].shape)


def _parabola(at: Image, here: Image, slope: Image, bend: Image) -> Image:
    place = at * bend
    place += slope
    place *= at
    place += here
    return place


def _flat(images: Image) -> Image:
    """Images (k, n, m) one above the other, (k n, m): so OpenCV takes them at once."""
    return images.reshape(-1, images.shape[-1])


class Template:
    """The reference warped for k radii, or for one that serves all: (k, n, m), ready to be correlated."""

    def __init__(self, image: Image, window: int) -> None:
        self._image, self._window = image, window
        self._mean = self._box(image)
        self._variance = self._box(image * image) - self._mean**2

    def correlate(self, other: Image) -> Image:
        """Normalised cross-correlation of every window with (k, n, m) others."""
        mean = self._box(other)
        scale = self._box(other * other)
        scale -= mean * mean
        scale *= self._variance
        np.maximum(scale, np.float32(1e-3), out=scale)
        scale += np.float32(1)
        product = self._box(self._image * other)
        product -= np.multiply(self._mean, mean, out=mean)
        return np.divide(product, np.sqrt(scale, out=scale), out=product)

    def _box(self, images: Image) -> Image:
        size = (self._window, self._window)
        means = cv2.boxFilter(_flat(images), cv2.CV_32F, size, borderType=cv2.BORDER_REFLECT)
        return np.asarray(means).reshape(images.shape)
