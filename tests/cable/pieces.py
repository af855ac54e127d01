"""Blocks cut out of a known cable by formula, each standing a known way off: no picture is taken here.

Every cell of a block is moved to where it truly belongs and asked for the radius and the texture there, so
that the block is a perfect piece of the cable, seen in a frame of its own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.cable.closest_fit import Placement
from pipeline.cable.crop import Crop
from pipeline.cable.measure import MeasureOptions, measure_ring
from pipeline.cable.mosaic import Mosaic, MosaicBlock
from pipeline.cable.relief import ReliefOptions
from pipeline.cable.ring import RingOptions, build_ring
from pipeline.cable.surface import BlockSurface
from pipeline.cable.texture import UnrolledPicture
from pipeline.cable.uncertainty import Uncertainty
from pipeline.core.axis import AxisCurve
from tests.cable import scene

TRAVEL_M, MARGIN_M, CELL_M, TEXEL_M, LIMB_DEG = 0.12, 0.02, 0.0008, 0.0005, 60.0
MIDDLE = np.array([0.0, TRAVEL_M / 2, 0.0])
STRAIGHT = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 2)))
STATIONS = (("A", 0.02), ("B", 0.06), ("C", 0.10))
SIGMAS = np.array([0.005, 0.005, 0.005, 0.001, 0.001, 0.001, 0.003])  # what a POS knows of a block


@dataclass(frozen=True)
class Motion:
    """Where a block truly belongs: X = middle + shift + scale R (X_own - middle)."""

    turn_deg: tuple = (0.0, 0.0, 0.0)
    shift_mm: tuple = (0.0, 0.0, 0.0)
    scale: float = 1.0

    def apply(self, points):
        R = Rotation.from_rotvec(np.radians(self.turn_deg)).as_matrix()
        return MIDDLE + np.array(self.shift_mm) / 1000 + self.scale * (points - MIDDLE) @ R.T


STILL = Motion()
# mountings off by some tenths of a degree and of a millimetre, as on a real robot
ASTRAY = (
    Motion((0.10, -0.20, 0.15), (0.4, -0.3, 0.2), 1.001),
    Motion((-0.20, 0.10, -0.10), (-0.3, 0.5, 0.3), 0.999),
    Motion((0.15, 0.20, 0.05), (0.2, 0.2, -0.5), 1.0005),
    Motion((-0.05, -0.10, -0.10), (-0.3, -0.4, 0.0), 0.9995),
)


def radius_m(azimuth, y_m):
    """A true cylinder."""
    return scene.RADIUS_M + 0 * azimuth


def _own_radius(azimuth, y_m, motion, true_radius):
    """Radius of the block's cells about its own axis, so that they lie on the true cable."""
    out = scene.out_of_cable(azimuth)
    radius = np.full(azimuth.shape, scene.RADIUS_M)
    for _ in range(5):
        points = motion.apply(radius[..., None] * out + y_m[..., None] * [0, 1, 0])
        around = np.arctan2(-points[..., 2], points[..., 0])
        radius = radius - (np.hypot(points[..., 0], points[..., 2]) - true_radius(around, points[..., 1]))
    return radius, around, points[..., 1]


def block(
    angle_deg,
    motion=STILL,
    true_radius=radius_m,
    texture=None,
    noise_mm=0.0,
    seed=0,
    limb_deg=LIMB_DEG,
    known_to=SIGMAS,
):
    """One block and its crop; ``texture`` None leaves the picture even and grey."""
    middle, limb = np.radians(angle_deg), np.radians(limb_deg)
    azimuth = middle + np.arange(-limb, limb, CELL_M / scene.RADIUS_M)
    y_m = np.arange(-MARGIN_M, TRAVEL_M + MARGIN_M, CELL_M)
    radius, _, _ = _own_radius(*np.meshgrid(azimuth, y_m), motion, true_radius)
    noise = np.random.default_rng(seed).normal(0, noise_mm / 1000, radius.shape)
    surface = BlockSurface(
        axis=STRAIGHT,
        azimuth=azimuth,
        y_m=y_m,
        radius_m=(radius + noise).astype(np.float32),
        measured=np.ones(radius.shape, dtype=bool),
        score=np.full(radius.shape, 0.9, dtype=np.float32),
    )
    turned = azimuth - middle
    incidence = np.abs(turned) + np.arctan2(
        scene.RADIUS_M * np.sin(np.abs(turned)), scene.STANDOFF_M - scene.RADIUS_M * np.cos(turned)
    )
    crop = Crop(keep=np.ones(radius.shape, dtype=bool), incidence_deg=np.degrees(incidence))
    return MosaicBlock(
        name=f"Block{angle_deg:g}",
        surface=surface,
        keep=crop.keep,
        picture=_picture(azimuth, y_m, motion, true_radius, texture),
        datum_origin=MIDDLE,
        datum_information=np.diag(1 / np.asarray(known_to) ** 2),
    ), crop


def _picture(azimuth, y_m, motion, true_radius, texture):
    columns = np.arange(azimuth[0], azimuth[-1], TEXEL_M / scene.RADIUS_M)
    rows = np.arange(y_m[0], y_m[-1], TEXEL_M)
    gray = np.full((len(rows), len(columns)), 128.0)
    if texture is not None:
        gray = texture(*_own_radius(*np.meshgrid(columns, rows), motion, true_radius)[1:])
    return UnrolledPicture(
        azimuth=columns,
        y_m=rows,
        colour=np.clip(np.rint(gray[..., None] * scene.TINT), 0, 255).astype(np.uint8),
        known=np.ones(gray.shape, dtype=bool),
        texel_mm=1000 * TEXEL_M,
    )


def ring(motions=(STILL,) * 4, **choices):
    """Four blocks around the cable and their crops."""
    made = [block(90.0 * n, motion, seed=n, **choices) for n, motion in enumerate(motions)]
    return tuple(b for b, _ in made), tuple(c for _, c in made)


def placement(motions):
    """The motions as the pipeline writes them."""
    return Placement(
        origins=np.tile(MIDDLE, (len(motions), 1)),
        rotations=np.stack([Rotation.from_rotvec(np.radians(m.turn_deg)).as_matrix() for m in motions]),
        shifts=np.array([m.shift_mm for m in motions]) / 1000,
        scales=np.array([m.scale for m in motions]),
    )


def placed(motions=(STILL,) * 4, covariance=None):
    """A mosaic that has found the truth."""
    size = 7 * len(motions)
    return Mosaic(
        placement=placement(motions),
        covariance=np.zeros((size, size)) if covariance is None else covariance,
        joins=(),
    )


def join(blocks, crops, mosaic=None, emit=scene.silent, **options):
    """The ring of blocks that stand right, or as the mosaic says."""
    mosaic = mosaic or placed((STILL,) * len(blocks))
    return build_ring(blocks, crops, mosaic, TRAVEL_M, RingOptions(**options), emit)


def measure(
    blocks,
    crops,
    mosaic=None,
    stations=STATIONS,
    noise_mm=0.03,
    window_mm=3.0,
    focal_share=0.0,
    travel_share=0.0,
    together=None,
    ring=None,
    emit=scene.silent,
    **options,
):
    """Measure blocks that stand right, or as the mosaic says."""
    mosaic = mosaic or placed((STILL,) * len(blocks))
    return measure_ring(
        blocks,
        crops,
        mosaic,
        ring or join(blocks, crops, mosaic, cell_mm=4.0, texel_mm=8.0),
        Uncertainty(
            noise_mm=(noise_mm,) * len(blocks),
            window_mm=(window_mm,) * len(blocks),
            focal_shares=(focal_share,) * len(blocks),
            travel_share=travel_share,
            together=together,
        ),
        stations,
        TRAVEL_M,
        9000 * CELL_M,
        MeasureOptions(**{"profile_mm": 40.0, **options}),
        ReliefOptions(),
        emit,
    )
