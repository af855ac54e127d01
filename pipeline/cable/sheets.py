"""Frames laid onto the predicted cylinder: sheets on which one piece of surface looks alike in all of them.

Takes original frames, their lens, predicted orientations and the cable's rough radius; gives pictures of
azimuth by place along the cable, and the way back from there to the frames.  In a frame itself the depth
varies so much across a template near the limb that frames shear against each other by pixels.  The way back
undoes the way there: the cylinder need not be the true surface.  Lighting travels with the robot; normalising
to local mean and contrast takes it out.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface_view import SurfaceView, SweepGrid, sample
from pipeline.core.axis import AxisCurve
from pipeline.core.division import project
from pipeline.core.vocabulary import Array, Lens, Poses

Gray = NDArray[np.uint8]


def normalise(image: NDArray[np.uint8] | NDArray[np.float32], radius_px: float) -> Gray:
    """Take out local mean and contrast: 128 + 40 standard deviations, (h, w) uint8."""
    away = image.astype(np.float32)
    away -= cv2.GaussianBlur(away, (0, 0), radius_px)
    spread = np.asarray(cv2.GaussianBlur(away * away, (0, 0), radius_px))
    spread += 4.0
    cv2.divide(away, np.sqrt(spread, out=spread), away, scale=40)
    return np.asarray(cv2.add(away, 128.0, dtype=cv2.CV_8U))  # rounds, and stops at 0 and 255


@dataclass(frozen=True, kw_only=True)
class Filmed:
    """A block's frames, and how they are thought to see the cable.

    Attributes:
        read: gives the grey original frame k, (h, w) uint8.
        lens: of the original frames.
        poses: predicted orientations.
        azimuth_deg: of the block's camera.
        axis: of the cable.
        radius_m: of the cable, roughly.
    """

    read: Callable[[int], Gray]
    lens: Lens
    poses: Poses
    azimuth_deg: float
    axis: AxisCurve
    radius_m: float


@dataclass(frozen=True)
class Sheet:
    """One frame laid onto the cylinder: (h, w) picture, the grid's row of its first row."""

    picture: Gray
    first_row: int


class Sheets:
    """All frames of one block as sheets, made when they are asked for.

    Places are (column, row) on the grid that all sheets share: columns turn around the cable by one texel,
    rows rise along it, row 0 at y = 0.

    Args:
        filmed: the frames.
        limb_deg: surface further than this from the camera's azimuth is left out...
        margin_px: ...but for so many texels.
        normalise_px: radius of the local mean and contrast.
        keep: so many sheets stay in memory.

    Attributes:
        along_m: (frames,) where each frame's camera stands along the cable.
        texel_m: side of a texel, a pixel's size on the surface.
        width, height: texels of every sheet, for OpenCV's tracker demands one size.
    """

    def __init__(
        self, filmed: Filmed, *, limb_deg: float, margin_px: float, normalise_px: float, keep: int
    ) -> None:
        self._filmed, self._normalise_px = filmed, normalise_px
        centres, lens, radius_m = filmed.poses.centres, filmed.lens, filmed.radius_m
        self.along_m = centres[:, 1]
        away = centres - filmed.axis.at(self.along_m)
        depth_m = float(np.median(np.hypot(away[:, 0], away[:, 2]))) - radius_m
        self.texel_m = depth_m / lens.focal_px
        turn = self.texel_m / radius_m
        limb = np.deg2rad(limb_deg) + margin_px * turn
        self._azimuth = np.deg2rad(filmed.azimuth_deg) + np.arange(-limb, limb, turn)
        self._reach = int(0.6 * max(lens.width_px, lens.height_px))
        self.width, self.height = len(self._azimuth), 2 * self._reach + 1
        self._keep = keep
        self._held: OrderedDict[int, Sheet] = OrderedDict()

    def __getitem__(self, frame: int) -> Sheet:
        if frame not in self._held:
            self._held[frame] = self._laid(frame)
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        self._held.move_to_end(frame)
        return self._held[frame]

    def _laid(self, frame: int) -> Sheet:
        first = round(self.along_m[frame] / self.texel_m) - self._reach
        y_m = (first + np.arange(self.height)) * self.texel_m
        filmed = self._filmed
        grid = SweepGrid(axis=filmed.axis, azimuth=self._azimuth, y_m=y_m)
        view = SurfaceView(filmed.lens, filmed.poses, frame, grid)
        pixels = view.pixels(np.full((self.height, self.width), filmed.radius_m, dtype=np.float32))
        # OpenCV's cubic moves edges by up to 0.05 px, depending on where between the pixels they lie
        picture = sample(filmed.read(frame).astype(np.float32), pixels, cv2.INTER_LANCZOS4)
        seen = view.visible(pixels, 1) > 0
        np.copyto(picture, cv2.mean(picture, seen.astype(np.uint8))[0], where=~seen)
        return Sheet(normalise(picture, self._normalise_px), first)

    def surface(self, places: Array) -> Array:
        """Points of the cylinder at places (m, 2), (m, 3) metres."""
        azimuth = self._azimuth[0] + places[:, 0] * (self._azimuth[1] - self._azimuth[0])
        y_m = places[:, 1] * self.texel_m
        return self._filmed.axis.roll(azimuth, y_m, np.full(len(places), self._filmed.radius_m))

    def places(self, azimuth: Array, y_m: Array) -> Array:
        """Places (m, 2) of azimuths (m,) in radians and y (m,) in metres."""
        middle = self._azimuth.mean()
        turned = middle + np.angle(np.exp(1j * (azimuth - middle)))
        column = (turned - self._azimuth[0]) / (self._azimuth[1] - self._azimuth[0])
        return np.stack([column, y_m / self.texel_m], axis=1)

    def hold(self, frame: int, places: Array, border_px: int) -> NDArray[np.bool_]:
        """Which places (m, 2) lie on the frame's sheet with a border around them."""
        row = places[:, 1] - self[frame].first_row
        inside = (row > border_px) & (row < self.height - border_px)
        return inside & (places[:, 0] > border_px) & (places[:, 0] < self.width - border_px)

    def pixels(self, frame: int, places: Array) -> Array:
        """Where the places were looked up in the original frame, (m, 2)."""
        poses = self._filmed.poses
        in_camera = self.surface(places) @ poses.rotations[frame].T + poses.translations[frame]
        return project(self._filmed.lens, in_camera)
