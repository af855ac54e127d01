"""From light to grey values: exposure, vignetting, photon and read-out noise, encoding; numpy only.

Takes the linear picture of the renderer, gives 8-bit frames.  Leaves out everything geometric.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array, Lens
from synth.spec import Sensor


def develop(light: Array, lens: Lens, sensor: Sensor, seed: tuple[int, ...]) -> NDArray[np.uint8]:
    """Expose one frame.

    Args:
        light: (height, width, 3) linear light, 1 is white at exposure 1.
        lens: its size and principal point, where the vignetting is centred.
        sensor: what the light goes through.
        seed: of this frame's noise.

    Returns:
        (height, width, 3) uint8, red, green, blue, encoded by the sRGB curve.
    """
    exposed = np.asarray(light, float) * sensor.exposure * falloff(lens, sensor.vignetting)[..., None]
    if sensor.full_well_e > 0.0:
        rng = np.random.default_rng(seed)
        electrons = np.clip(exposed, 0.0, None) * sensor.full_well_e
        sigma = np.sqrt(electrons + sensor.read_noise_e**2)  # Poisson noise is normal at these counts
        exposed = (electrons + sigma * rng.standard_normal(exposed.shape)) / sensor.full_well_e
    linear = np.clip(exposed, 0.0, 1.0)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.rint(coded * 255.0), np.uint8)


def falloff(lens: Lens, strength: float) -> Array:
    """Vignetting (height, width): 1 at the principal point, 1 - strength at half the diagonal from it."""
    v, u = np.mgrid[: lens.height_px, : lens.width_px] + 0.5
    cx, cy = lens.principal_point_px
    squared = ((u - cx) ** 2 + (v - cy) ** 2) / ((lens.width_px**2 + lens.height_px**2) / 4.0)
    return np.asarray(np.clip(1.0 - strength * squared, 0.0, 1.0), float)
