"""The depth of one photo, pixel by pixel: the sweep of the cable's surface generalised to lines of sight.

Takes a photo, its neighbours, lens and orientations; gives depth, correlation and angle for every cell of the
photo's grid.  Every cell's candidates lie on its own line of sight, evenly spaced in inverse depth; the
neighbours are sampled there and compared by box-filtered normalised cross-correlation; the mean of the two
best neighbours counts, since the others may not see the place; a parabola refines the peak.  Only the best
candidate and those beside it are kept, so memory does not grow with their number.

Sources: R. T. Collins, "A space-sweep approach to true multi-image matching", CVPR 1996; the best
neighbours: S. B. Kang, R. Szeliski and J. Chai, "Handling occlusions in dense multi-view stereo", CVPR 2001.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.core.division import coefficient, pixels_to_rays
from pipeline.core.vocabulary import Array, Lens, Poses
from pipeline.steel.photo_correlation import Image, Peak, Template, sample
from pipeline.steel.photo_records import DepthOptions


@dataclass(frozen=True, kw_only=True)
class DepthMap:
    """Depths of one photo, on a grid of every ``step_px``-th pixel.

    Attributes:
        depth: (h, w) along the camera's z, photo units; NaN where nothing can be said.
        score: (h, w) correlation at the peak.
        neighbours: numbers of the photos that it was compared with.
        step_px: grid spacing; cell (0, 0) is centred on pixel (step / 2, step / 2).
    """

    depth: Image
    score: Image
    neighbours: tuple[int, ...]
    step_px: int


def grid_pixels(lens: Lens, step_px: int) -> Array:
    """(h, w, 2) pixels of the cells' centres, origin at the corner."""
    columns = np.arange(lens.width_px // step_px) * step_px + step_px / 2
    rows = np.arange(lens.height_px // step_px) * step_px + step_px / 2
    return np.stack(np.meshgrid(columns, rows), axis=-1)


def grid_rays(lens: Lens, step_px: int) -> Array:
    """(h, w, 3) directions of the cells' lines of sight, z = 1, camera frame."""
    pixels = grid_pixels(lens, step_px)
    rays = pixels_to_rays(lens, pixels.reshape(-1, 2)).reshape(pixels.shape)
    return np.concatenate([rays, np.ones_like(rays[..., :1])], axis=-1)


def sweep_photo(
    pictures: Callable[[int], Image],
    lens: Lens,
    poses: Poses,
    reference: int,
    neighbours: tuple[int, ...],
    nearest: float,
    farthest: float,
    options: DepthOptions,
    tick: Callable[[float], None],
) -> DepthMap:
    """Sweep one photo.

    Args:
        pictures: gives a photo, grey, blurred to the grid.
        lens: common to all, distortion included.
        poses: cam_from_photo frame.
        reference: number of the photo.
        neighbours: photos to compare it with.
        nearest, farthest: depths between which to search.
        options: see there.
        tick: called with the share done, at least every half second.
    """
    rays = grid_rays(lens, options.step_px).astype(np.float32)
    paths = [_Path(lens, poses, reference, other, rays) for other in neighbours]
    window = max(options.window_px // options.step_px | 1, 3)
    own = grid_pixels(lens, options.step_px).astype(np.float32) - np.float32(0.5)
    template = Template(sample(pictures(reference), own[..., 0], own[..., 1]), window)
    inverse = _candidates(paths, nearest, farthest, options)
    views = _Views(template=template, paths=paths, images=[pictures(other) for other in neighbours])
    found, score = views.peak(map(np.float32, inverse), len(inverse), lambda share: tick(0.8 * share))
    spacing = inverse[1] - inverse[0]
    start = np.where(score >= options.least_score, inverse[0] + found * spacing, np.nan).astype(np.float32)
    step = np.float32(spacing / options.candidate_px)
    start = _smooth(start, options.slope_px * float(step), window)
    # again about a smooth start: its windows lie on the surface's slope, not square to the camera
    offsets = np.linspace(-1.5, 1.5, 13, dtype=np.float32) * step
    about = np.nan_to_num(start, nan=float(inverse[0]))
    found, score = views.peak(
        (about + offset for offset in offsets), len(offsets), lambda share: tick(0.8 + 0.2 * share)
    )
    depth = 1 / (start + offsets[0] + found * (offsets[1] - offsets[0]))
    good = np.isfinite(found) & (score >= options.least_score) & template.textured
    return DepthMap(
        depth=np.where(good, depth, np.nan).astype(np.float32),
        score=np.where(good, score, np.nan).astype(np.float32),
        neighbours=neighbours,
        step_px=options.step_px,
    )


@dataclass(frozen=True, kw_only=True)
class _Views:
    """A photo's windows and the neighbours they are looked for in."""

    template: Template
    paths: list["_Path"]
    images: list[Image]

    def peak(
        self, candidates: Iterable[np.float32 | Image], count: int, tick: Callable[[float], None]
    ) -> tuple[Image, Image]:
        """Which of ``count`` inverse depths fits best, cell by cell, with a fraction, and its score."""
        peak = Peak(self.template.textured.shape)
        for number, inverse in enumerate(candidates):
            if number % 4 == 0:
                tick(number / count)
            scores = [
                self.template.correlate(path.sample(image, inverse))
                for path, image in zip(self.paths, self.images, strict=True)
            ]
            peak.add(_best_two(scores))
        return peak.at()


def _candidates(paths: list["_Path"], nearest: float, farthest: float, options: DepthOptions) -> Array:
    """Inverse depths at which the widest neighbour moves on by ``candidate_px``."""
    shift = max(path.shift_px(1 / farthest, 1 / nearest) for path in paths)
    count = int(np.clip(shift / options.candidate_px, 8, options.most_candidates)) + 1
    return np.linspace(1 / farthest, 1 / nearest, count)


def _smooth(inverse: Image, slack: float, window: int) -> Image:
    """Mean over a window of those within ``slack`` of the cell's own value, twice; NaN where there is none.

    A surface's slope stays, since a plane is linear in inverse depth; a step in depth stays too.
    """
    height, width = inverse.shape
    for _ in range(2):
        total, count = np.zeros_like(inverse), np.zeros_like(inverse)
        padded = np.pad(inverse, window, constant_values=np.nan)
        for down in range(0, 2 * window + 1, 2):
            for right in range(0, 2 * window + 1, 2):
                other = padded[down : down + height, right : right + width]
                with np.errstate(invalid="ignore"):
                    near = np.abs(other - inverse) < slack
                total += np.where(near, other, 0)
                count += near
        inverse = np.where(count > 0, total / np.maximum(count, 1), np.nan).astype(np.float32)
    return inverse


def _best_two(scores: list[Image]) -> Image:
    """Mean of the two best neighbours' scores; of the only one where there is one."""
    if len(scores) == 1:
        return scores[0]
    best, second = np.maximum(scores[0], scores[1]), np.minimum(scores[0], scores[1])
    for score in scores[2:]:
        np.maximum(second, np.minimum(best, score), out=second)
        np.maximum(best, score, out=best)
    return np.asarray((best + second) / 2, dtype=np.float32)


class _Path:
    """Where a neighbour sees the cells, for any inverse depth."""

    def __init__(self, lens: Lens, poses: Poses, reference: int, other: int, rays: Image) -> None:
        rotation = poses.rotations[other] @ poses.rotations[reference].T
        move = poses.translations[other] - rotation @ poses.translations[reference]
        self._far = np.moveaxis(rays @ rotation.T.astype(np.float32), -1, 0)
        self._move = move.astype(np.float32)
        self._lens, self._k = lens, np.float32(coefficient(lens))

    def pixels(self, inverse: np.float32 | Image) -> tuple[Image, Image]:
        """Columns and rows, OpenCV's origin; far outside where the camera does not see."""
        x, y, z = (far + inverse * step for far, step in zip(self._far, self._move, strict=True))
        # behind the camera: far beside the picture
        np.maximum(z, np.float32(1e-4), out=z)
        scale = np.divide(np.float32(self._lens.focal_px), z, out=z)
        if self._k:
            rho = (x * x + y * y) * (scale / np.float32(self._lens.focal_px)) ** 2
            scale = scale * 2 / (1 + np.sqrt(np.maximum(1 - 4 * self._k * rho, 0)))
        x *= scale
        y *= scale
        cx, cy = self._lens.principal_point_px
        x += np.float32(cx - 0.5)
        y += np.float32(cy - 0.5)
        return x, y

    def sample(self, image: Image, inverse: np.float32 | Image) -> Image:
        """The neighbour's values at the cells; NaN-like (-1e3) where it does not see them."""
        return sample(image, *self.pixels(inverse))

    def shift_px(self, first: float, last: float) -> float:
        """How far the cells move between two inverse depths, nearly the most."""
        a, b = self.pixels(np.float32(first)), self.pixels(np.float32(last))
        inside = (np.abs(a[0]) < 1e4) & (np.abs(b[0]) < 2e4) & (np.abs(b[1]) < 2e4)
        if not inside.any():
            return 0.0
        return float(np.percentile(np.hypot(a[0] - b[0], a[1] - b[1])[inside], 60))
