"""How far one photograph of a cable was taken from another along it, from the pictures alone.

Takes grey pictures of one camera, its lens as stated and the cable's rough radius; gives SIFT marks laid onto
the cylinder, and for two pictures the shift between them with the number of marks that agree on it.  Nothing
is predicted, so the pictures may come in any order.  Leaves out what the shifts of many pairs say together
(:mod:`pipeline.cable.ordering`) and tie points: once the places are known, :mod:`pipeline.cable.tracking`
finds those three times sharper.

Sources: D. Lowe, IJCV 60(2), 2004 (SIFT and the ratio test); R. Arandjelovic and A. Zisserman, CVPR 2012
(the square root of the descriptors).
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.sheets import Gray, normalise
from pipeline.core.division import pixels_to_rays
from pipeline.core.rotations import nominal_cam_from_world
from pipeline.core.vocabulary import Array, Lens, TravelDirection


@dataclass(frozen=True, kw_only=True)
class SiftOptions:
    """How marks are found and compared.

    Attributes:
        marks: most marks in one picture, the strongest.
        limb_deg: marks further than this from the camera's azimuth are left out, and so is the background.
        band_share: a mark is looked for this far around the cable, in shares of the stand-off: the camera
            keeps its azimuth, but for the sway.
        ratio: a match counts where it is nearer than this share of the second best in that band.
        agree_share: marks agree on a shift within this share of the stand-off; sway turns pictures so far.
        least_marks: fewer marks that agree are no shift.
        clear: so many times more marks must agree than on any other shift.
    """

    marks: int = field(default=1000, metadata={"minimum": 20})
    limb_deg: float = field(default=58.0, metadata={"above": 0.0, "maximum": 85.0})
    band_share: float = field(default=0.03, metadata={"above": 0.0})
    ratio: float = field(default=0.95, metadata={"above": 0.0, "maximum": 1.0})
    agree_share: float = field(default=0.015, metadata={"above": 0.0})
    least_marks: int = field(default=8, metadata={"minimum": 4})
    clear: float = field(default=2.0, metadata={"minimum": 1.0})


@dataclass(frozen=True, kw_only=True)
class CableView:
    """A camera's view of the cable, roughly: what turns pixels into places on it.

    Attributes:
        lens: as stated.
        travel_in_image: where +y points.
        standoff_m: projection centre to axis.
        radius_m: of the cable.
    """

    lens: Lens
    travel_in_image: TravelDirection
    standoff_m: float
    radius_m: float

    def places(self, pixels: Array) -> Array:
        """Places on the cylinder (n, 2) metres: arc and distance along, from the point before the camera.

        NaN beside the cable.
        """
        attitude = nominal_cam_from_world(0.0, self.travel_in_image)
        rays = pixels_to_rays(self.lens, pixels)
        x, y, z = (np.column_stack([rays, np.ones(len(rays))]) @ attitude).T
        square, half = x**2 + z**2, self.standoff_m * x
        with np.errstate(invalid="ignore"):
            inside = half**2 - square * (self.standoff_m**2 - self.radius_m**2)
            far = (-half - np.sqrt(inside)) / square
        azimuth = np.arctan2(-far * z, self.standoff_m + far * x)
        return np.stack([self.radius_m * azimuth, far * y], axis=1)

    def mask(self, limb_deg: float) -> Gray:
        """255 where the cable is seen within this angle of the camera's azimuth, (h, w)."""
        column, row = np.meshgrid(np.arange(self.lens.width_px) + 0.5, np.arange(self.lens.height_px) + 0.5)
        arc = self.places(np.stack([column.ravel(), row.ravel()], axis=1))[:, 0].reshape(column.shape)
        return (np.abs(arc) < self.radius_m * np.radians(limb_deg)).astype(np.uint8) * 255


@dataclass(frozen=True, kw_only=True)
class Marks:
    """The SIFT marks of one picture.

    Attributes:
        places: (n, 2) on the cylinder, metres, from the point before the camera: arc, along.
        descriptors: (n, 128) float32 of length 1.
    """

    places: Array
    descriptors: NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class Shift:
    """What two pictures say of each other.

    Attributes:
        along_m: place of the second along the cable less that of the first.
        marks: so many agree on it.
    """

    along_m: float
    marks: int


def find_marks(picture: Gray, view: CableView, mask: Gray, options: SiftOptions) -> Marks:
    """SIFT marks of one grey picture (h, w) where the mask is set.

    Local mean and contrast are taken out first: the lamp travels with the camera.
    """
    # without the precise upscaling OpenCV's places are a quarter of a pixel off, both ways
    sift = cv2.SIFT.create(options.marks, contrastThreshold=0.02, enable_precise_upscale=True)
    found, raw = sift.detectAndCompute(normalise(picture, 9.0), mask)
    if raw is None:
        return Marks(places=np.zeros((0, 2)), descriptors=np.zeros((0, 128), dtype=np.float32))
    # OpenCV's places count from the first pixel's centre, ours from its corner
    pixels = np.array([mark.pt for mark in found]) + 0.5
    root = np.sqrt(raw / np.maximum(raw.sum(axis=1, keepdims=True), 1e-9))
    return Marks(places=view.places(pixels), descriptors=root.astype(np.float32))


def find_shift(first: Marks, second: Marks, standoff_m: float, options: SiftOptions) -> Shift | None:
    """The shift along the cable that most of the common marks agree on; None where too few do.

    A surface seen from a camera that glides along it shifts as a whole, a little around the cable too where
    the camera sways.  That is a far stricter test of matches than a fundamental matrix, which a smooth
    surface seen in pure translation hardly determines.
    """
    a, b = mutual_matches(first, second, options.band_share * standoff_m, options.ratio)
    if len(a) < options.least_marks:
        return None
    moved, agree_m = first.places[a] - second.places[b], options.agree_share * standoff_m
    support = np.sum(np.linalg.norm(moved[:, None] - moved[None, :], axis=2) < agree_m, axis=1)
    centre = moved[np.argmax(support)]
    elsewhere = np.linalg.norm(moved - centre, axis=1) > 2 * agree_m
    runner_up = int(np.max(support[elsewhere], initial=0))
    for _ in range(3):
        agreed = np.linalg.norm(moved - centre, axis=1) < agree_m
        centre = np.median(moved[agreed], axis=0)
    count = int(agreed.sum())
    if count < max(options.least_marks, options.clear * runner_up):
        return None
    return Shift(along_m=float(moved[agreed, 1].mean()), marks=count)


def mutual_matches(
    first: Marks, second: Marks, band_m: float, ratio: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Marks that are each other's best in their band around the cable, and better than the second best.

    Returns:
        (k,) numbers in the first, (k,) numbers in the second.
    """
    if min(len(first.places), len(second.places)) < 2:
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    alike = first.descriptors @ second.descriptors.T
    alike[np.abs(first.places[:, None, 0] - second.places[None, :, 0]) > band_m] = 0.0
    best, back = alike.argmax(axis=1), alike.argmax(axis=0)
    a = np.flatnonzero(back[best] == np.arange(len(best)))
    b = best[a]
    top = alike[a, b]
    alike[a, b] = 0.0
    runner_up = np.maximum(alike[a].max(axis=1), alike[:, b].max(axis=0))
    # for unit vectors the squared distance is 2 - 2 cos
    clear = (top > 0) & (1 - top < ratio**2 * (1 - runner_up))
    return a[clear], b[clear]
