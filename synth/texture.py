"""The painted-on look of the cable: albedo and roughness of the unrolled surface, from a seed.

Takes the cable and a seed, gives one picture (rows along the axis, columns around it, closed around the
girth).  Layers are filtered noise and drawn marks, in the way a sheath ages: grain, soot, running water,
scrapes, specks.  Never touches the geometry: no bump, no displacement.
"""

import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from synth.spec import Cable, MaterialKind, Robot
from synth.surface import base_radius_m

Picture = NDArray[np.float32]

BASE_ALBEDO = {MaterialKind.HDPE: (0.30, 0.305, 0.30), MaterialKind.PAINTED: (0.44, 0.45, 0.42)}
BASE_ROUGHNESS = {MaterialKind.HDPE: 0.62, MaterialKind.PAINTED: 0.45}
SOOT_TINT = (0.92, 1.0, 1.12)  # dirt swallows blue most


def surface_texture(cable: Cable, robot: Robot, seed: int) -> Picture:
    """Albedo and roughness of the whole sheath.

    Args:
        cable: size, material and strengths.
        robot: its travel, which with the margins gives the length.
        seed: of every layer.

    Returns:
        (rows, columns, 4) float32 in 0..1: linear red, green, blue albedo and roughness; row 0 lies at
        y = -margin, column 0 at azimuth 0.
    """
    rows, columns = texture_shape(cable, robot)
    material, texel = cable.material, cable.material.texel_mm
    rng = np.random.default_rng([seed, 41])
    layers = _Layers(rng, (rows, columns), texel, material.drawn_out)
    grain = material.grain * 2.0
    log_albedo = 0.12 * grain * layers.noise(0.3, 2.5) + 0.08 * grain * layers.noise(1.5, 14.0)
    log_albedo += 0.20 * material.mottling * layers.noise(15.0, 150.0)
    streaks = layers.streaks()
    soot = layers.dirt() * material.dirt + np.clip(streaks, 0.0, None) * material.streaks * 0.6
    log_albedo += material.streaks * 0.30 * np.clip(-streaks, 0.0, None)  # washed clean
    scratches, specks = layers.scratches(), layers.specks(material.speck_density)
    log_albedo += material.scratches * 1.1 * scratches + material.speckle * 1.3 * specks
    tint = np.array(SOOT_TINT, np.float32)
    exponent = log_albedo[..., None] - 1.1 * soot[..., None] * tint
    albedo = np.array(BASE_ALBEDO[material.kind], np.float32) * np.exp(exponent)
    roughness = BASE_ROUGHNESS[material.kind] + 0.25 * soot + 0.05 * grain * layers.noise(1.0, 10.0)
    return np.clip(np.dstack([albedo, roughness]), 0.02, 0.90).astype(np.float32)


def texture_shape(cable: Cable, robot: Robot) -> tuple[int, int]:
    """Rows along the axis and columns around it."""
    texel_m = cable.material.texel_mm / 1000.0
    length_m = robot.travel_m + 2.0 * cable.margin_m
    return math.ceil(length_m / texel_m), math.ceil(2.0 * math.pi * base_radius_m(cable) / texel_m)


def encode(texture: Picture) -> NDArray[np.uint8]:
    """Picture (rows, columns, 4) uint8: sRGB-encoded colour, linear roughness in the fourth channel."""
    colour = texture[..., :3]
    coded = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * np.power(colour, 1.0 / 2.4) - 0.055)
    return np.asarray(np.rint(np.dstack([coded, texture[..., 3]]) * 255.0), np.uint8)


class _Layers:
    """The layers of one texture, each drawn from the same generator in a fixed order."""

    def __init__(
        self, rng: np.random.Generator, shape: tuple[int, int], texel_mm: float, drawn_out: float
    ) -> None:
        self._rng = rng
        self._shape = shape
        self._texel_mm = texel_mm
        self._drawn_out = drawn_out
        self._along = np.abs(fft.fftfreq(shape[0], texel_mm)).astype(np.float32)[:, None]  # cycles per mm
        self._around = fft.rfftfreq(shape[1], texel_mm).astype(np.float32)[None, :]

    def noise(self, finest_mm: float, coarsest_mm: float, stretch: float = 1.0) -> Picture:
        """Noise of unit variance, equal power per octave between two wavelengths, longer along the axis."""
        frequency = np.hypot(self._along * stretch * self._drawn_out, self._around)
        low, high = 1.0 / coarsest_mm, 1.0 / finest_mm
        gain = np.where(frequency > 0.0, 1.0 / np.maximum(frequency, low), 0.0)
        gain *= np.exp(-((frequency / high) ** 2)) * (1.0 - np.exp(-((frequency / low) ** 2)))
        white = self._rng.standard_normal(self._shape, dtype=np.float32)
        shaped = fft.irfft2(fft.rfft2(white, workers=1) * gain.astype(np.float32), self._shape, workers=1)
        return np.asarray(shaped / shaped.std(), np.float32)

    def dirt(self) -> Picture:
        """Blotches with ragged edges, 0 to about 1."""
        blotch = self.noise(2.0, 90.0) + 0.35 * self.noise(0.4, 4.0)
        return np.asarray(_smoothstep(blotch, 0.3, 2.2), np.float32)

    def streaks(self) -> Picture:
        """Marks of running water: thin across, long along the axis; dark positive, washed negative."""
        thin = self.noise(1.0, 9.0, stretch=45.0)
        patchy = _smoothstep(self.noise(8.0, 120.0, stretch=3.0), -0.6, 1.2)
        sign = np.sign(thin)
        return np.asarray(sign * _smoothstep(np.abs(thin), 0.8, 2.4) * patchy, np.float32)

    def scratches(self) -> Picture:
        """Thin scrapes, mostly light, -1 to 1."""
        area_mm2 = self._shape[0] * self._shape[1] * self._texel_mm**2
        canvas = np.zeros(self._shape, np.float32)
        for sign, per_m2 in ((1.0, 900), (-1.0, 500)):
            drawn = np.zeros(self._shape, np.uint8)
            for _ in range(int(per_m2 * area_mm2 / 1e6)):
                self._scratch(drawn)
            canvas += sign * drawn.astype(np.float32) / 255.0
        return canvas

    def _scratch(self, drawn: NDArray[np.uint8]) -> None:
        rng, texel = self._rng, self._texel_mm
        length = rng.lognormal(math.log(12.0), 0.8) / texel
        heading = rng.normal(0.0, 0.35) + (math.pi / 2.0 if rng.random() < 0.6 else 0.0)
        bend = rng.normal(0.0, 0.3)
        steps = np.linspace(0.0, 1.0, 9)
        headings = heading + bend * steps
        x = rng.uniform(0, self._shape[1]) + length * np.cumsum(np.cos(headings)) / 9.0
        y = rng.uniform(0, self._shape[0]) + length * np.cumsum(np.sin(headings)) / 9.0
        level = int(rng.uniform(60, 255))
        for turn in (-1, 0, 1):  # drawn across the seam too
            points = np.rint(16.0 * np.stack([x + turn * self._shape[1], y], axis=1)).astype(np.int32)
            cv2.polylines(drawn, [points[:, None]], False, level, 1, cv2.LINE_AA, 4)

    def specks(self, density: float) -> Picture:
        """Small round specks of several sizes, dark and light; a density of 1 is the usual number."""
        total = np.zeros(self._shape, np.float32)
        for radius_mm, per_cm2, weight in (
            (0.25, 9.0, 0.8),
            (0.5, 2.5, 0.9),
            (1.0, 0.35, 0.7),
            (2.2, 0.04, 0.5),
        ):
            total += weight * self._specks_of(radius_mm, density * per_cm2 / self._drawn_out)
        return np.clip(total, -1.0, 1.0)

    def _specks_of(self, radius_mm: float, per_cm2: float) -> Picture:
        """Impulses at random places, grown to ragged blobs."""
        rng, (rows, columns) = self._rng, self._shape
        count = int(per_cm2 * rows * columns * self._texel_mm**2 / 100.0)
        impulses = np.zeros(self._shape, np.float32)
        strength = rng.uniform(0.3, 1.0, count) * np.where(rng.random(count) < 0.65, -1.0, 1.0)
        impulses[rng.integers(0, rows, count), rng.integers(0, columns, count)] = strength
        sigma = radius_mm / self._texel_mm / 1.5
        long = sigma * self._drawn_out
        across, along = math.ceil(4.0 * sigma), math.ceil(4.0 * long)
        wrapped = cv2.copyMakeBorder(impulses, along, along, across, across, cv2.BORDER_WRAP)
        size = (2 * across + 1, 2 * along + 1)
        blurred = cv2.GaussianBlur(wrapped, size, sigma, sigmaY=long)[along:-along, across:-across]
        return np.asarray(np.tanh(1.6 * blurred * 2.0 * math.pi * sigma * long), np.float32)


def _smoothstep(x: Picture, low: float, high: float) -> Picture:
    s = np.clip((x - low) / (high - low), 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s), np.float32)
