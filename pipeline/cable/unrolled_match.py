"""Corresponding points of two neighbouring blocks, found in their unrolled pictures.

Both cameras see the line between them at about fifty degrees; unrolled, the two pictures of that strip
differ by little more than a shift.  Takes two unrolled pictures; gives corresponding places on both
surfaces.  Corners of the first are sought by normalised correlation, must agree with their neighbours on a
smooth (affine) shift, and are refined by tracking there and back.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.sheets import normalise
from pipeline.cable.texture import UnrolledPicture
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class UnrolledMatchOptions:
    """How neighbours are matched.

    Attributes:
        points: corners tried in the first picture.
        patch_mm: side of the patch that is compared.
        search_mm: largest shift between the pictures.
        least_score: smallest correlation of a patch.
        agreement_mm: largest distance from the common shift.
        least_share: so many of the well correlated corners must agree on it; of true neighbours nearly all
            do, of strangers a tenth by chance.
        round_trip_mm: tracking there and back must end this close to the start.
    """

    points: int = field(default=800, metadata={"minimum": 1})
    patch_mm: float = field(default=7.0, metadata={"above": 0.0})
    search_mm: float = field(default=4.0, metadata={"above": 0.0})
    least_score: float = field(default=0.55, metadata={"minimum": 0.0, "maximum": 1.0})
    agreement_mm: float = field(default=0.4, metadata={"above": 0.0})
    least_share: float = field(default=0.3, metadata={"minimum": 0.0, "maximum": 1.0})
    round_trip_mm: float = field(default=0.1, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Correspondences:
    """Places on two surfaces that show the same mark, (k, 2) each: azimuth in radians, y in metres."""

    first: Array
    second: Array


@dataclass(frozen=True)
class _Common:
    """Two pictures on one grid: (n, m) uint8, the cells known in both, and the grid."""

    first: NDArray[np.uint8]
    second: NDArray[np.uint8]
    known: NDArray[np.uint8]
    azimuth: Array
    y_m: Array
    turn: float
    texel_mm: float

    def surface(self, pixels: Array, turn: float) -> Array:
        """Pixels (k, 2), first pixel's centre at 0, to (azimuth, y)."""
        azimuth = self.azimuth[0] + pixels[:, 0] * (self.azimuth[1] - self.azimuth[0]) - turn
        return np.stack([azimuth, self.y_m[0] + pixels[:, 1] * (self.y_m[1] - self.y_m[0])], axis=1)


def match_unrolled(
    first: UnrolledPicture, second: UnrolledPicture, radius_m: float, options: UnrolledMatchOptions
) -> Correspondences:
    """Find corresponding places; none where the pictures do not overlap."""
    nothing = Correspondences(first=np.zeros((0, 2)), second=np.zeros((0, 2)))
    common = _overlay(first, second, radius_m, options)
    if common is None:
        return nothing
    found = cv2.goodFeaturesToTrack(common.first, options.points, 0.01, 4, mask=common.known, blockSize=7)
    if found is None:
        return nothing
    start = found[:, 0].astype(np.float64)
    shift, score = _correlate(common, start, options)
    agreed = _consensus(start, shift, score, common.texel_mm, options)
    if agreed is None:
        return nothing
    start, guess = start[agreed[0]], start[agreed[0]] + agreed[1][agreed[0]]
    end, good = _refine(common, start, guess, options)
    return Correspondences(
        first=common.surface(start[good], 0.0), second=common.surface(end[good], common.turn)
    )


def _overlay(
    first: UnrolledPicture, second: UnrolledPicture, radius_m: float, options: UnrolledMatchOptions
) -> _Common | None:
    """Bring the overlap of both pictures to one grid."""
    turn = 2 * np.pi * round((first.azimuth.mean() - second.azimuth.mean()) / (2 * np.pi))
    low = max(first.azimuth[0], second.azimuth[0] + turn)
    high = min(first.azimuth[-1], second.azimuth[-1] + turn)
    bottom, top = max(first.y_m[0], second.y_m[0]), min(first.y_m[-1], second.y_m[-1])
    texel_mm = max(first.texel_mm, second.texel_mm)
    if (high - low) * radius_m < options.patch_mm / 1000 or top - bottom < options.patch_mm / 1000:
        return None
    azimuth = np.arange(low, high, texel_mm / 1000 / radius_m)
    y_m = np.arange(bottom, top, texel_mm / 1000)
    grays, knowns = [], []
    for picture, by in ((first, 0.0), (second, turn)):
        column = np.interp(azimuth, picture.azimuth + by, np.arange(len(picture.azimuth)))
        row = np.interp(y_m, picture.y_m, np.arange(len(picture.y_m)))
        where = np.meshgrid(column.astype(np.float32), row.astype(np.float32))
        gray = cv2.cvtColor(picture.colour, cv2.COLOR_BGR2GRAY)
        # not cubic: OpenCV's kernel (a = -0.75) moves edges by up to 0.05 texels, here all of them alike
        grays.append(normalise(cv2.remap(gray, where[0], where[1], cv2.INTER_LINEAR), 3.0 / texel_mm))
        knowns.append(cv2.remap(picture.known.astype(np.uint8), where[0], where[1], cv2.INTER_NEAREST))
    margin = np.ones((5, 5), dtype=np.uint8)
    known = cv2.erode(knowns[0] & knowns[1], margin, borderValue=0)
    return _Common(grays[0], grays[1], known, azimuth, y_m, float(turn), texel_mm)


def _correlate(common: _Common, start: Array, options: UnrolledMatchOptions) -> tuple[Array, Array]:
    """Best whole-pixel shift of each corner's patch and its correlation: (k, 2), (k,)."""
    half = max(round(options.patch_mm / common.texel_mm / 2), 4)
    reach = max(round(options.search_mm / common.texel_mm), 2)
    border = half + reach
    wide = cv2.copyMakeBorder(common.second, border, border, border, border, cv2.BORDER_REFLECT)
    near = cv2.copyMakeBorder(common.first, half, half, half, half, cv2.BORDER_REFLECT)
    shifts, scores = np.zeros_like(start), np.zeros(len(start))
    for index, (column, row) in enumerate(np.rint(start).astype(int)):
        patch = near[row : row + 2 * half + 1, column : column + 2 * half + 1]
        area = wide[row : row + 2 * border + 1, column : column + 2 * border + 1]
        _, scores[index], _, place = cv2.minMaxLoc(cv2.matchTemplate(area, patch, cv2.TM_CCOEFF_NORMED))
        shifts[index] = np.array(place) - reach
    return shifts, scores


def _consensus(
    start: Array, shift: Array, score: Array, texel_mm: float, options: UnrolledMatchOptions
) -> tuple[NDArray[np.bool_], Array] | None:
    """The affine shift that most corners agree on: who agrees, and the shift everywhere (k, 2)."""
    keep = score > options.least_score
    least = max(8, options.least_share * keep.sum())
    if keep.sum() < least:
        return None
    tolerance = options.agreement_mm / texel_mm
    middle = _densest(shift[keep], tolerance)
    keep &= np.linalg.norm(shift - middle, axis=1) < 4 * tolerance
    design = np.column_stack([np.ones(len(start)), start - start.mean(axis=0)])
    common = np.broadcast_to(middle, shift.shape)
    for _ in range(5):
        if keep.sum() < least:
            return None
        common = design @ np.linalg.lstsq(design[keep], shift[keep], rcond=None)[0]
        keep = (score > options.least_score) & (np.linalg.norm(shift - common, axis=1) < 2 * tolerance)
    return (keep, common) if keep.sum() >= least else None


def _densest(shift: Array, tolerance: float) -> Array:
    """The shift with the most others close to it."""
    close = np.linalg.norm(shift[:, None] - shift[None], axis=2) < 2 * tolerance
    best = int(np.argmax(close.sum(axis=1)))
    return np.asarray(np.median(shift[close[best]], axis=0))


def _refine(
    common: _Common, start: Array, guess: Array, options: UnrolledMatchOptions
) -> tuple[Array, NDArray[np.bool_]]:
    window = (max(round(options.patch_mm / common.texel_mm), 9),) * 2
    ends, found = _flow(common.first, common.second, start, guess, window)
    back, returned = _flow(common.second, common.first, ends, start, window)
    near = np.linalg.norm(back - start, axis=1) < options.round_trip_mm / common.texel_mm
    agrees = np.linalg.norm(ends - guess, axis=1) < options.agreement_mm / common.texel_mm
    return ends, found & returned & near & agrees


def _flow(
    source: NDArray[np.uint8],
    target: NDArray[np.uint8],
    start: Array,
    guess: Array,
    window: tuple[int, int],
) -> tuple[Array, NDArray[np.bool_]]:
    moved, found, _ = cv2.calcOpticalFlowPyrLK(
        source,
        target,
        np.ascontiguousarray(start[:, None], dtype=np.float32),
        np.ascontiguousarray(guess[:, None], dtype=np.float32),
        winSize=window,
        maxLevel=0,
        criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 40, 0.005),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return moved[:, 0].astype(np.float64), found[:, 0] == 1
