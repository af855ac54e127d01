"""Pictures of a cable before a sky, drawn by numpy with edges known to a thousandth of a pixel."""

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr


def picture_of_cable(
    upper,
    lower,
    *,
    seed=0,
    width=960,
    height=600,
    cable=(120, 120, 120),
    sky=(185, 170, 160),
    texture=12.0,
    blur_px=0.7,
    shift_px=0.0,
):
    """(h, w, 3) uint8 with the cable between two curves.

    Args:
        upper, lower: y of the edges as a function of x, pixels from the picture's corner.
        seed: of texture and noise.
        width, height: size.
        cable, sky: mean colours, blue-green-red.
        texture: standard deviation of the cable's texture, grey levels, in grains and blotches.
        blur_px: standard deviation of the lens's blur.
        shift_px: how far the texture has moved along x.
    """
    rng = np.random.default_rng(seed)
    x, y = np.arange(width) + 0.5, np.arange(height)[:, None] + 0.5
    inside = ndtr((y - upper(x)) / blur_px) * ndtr((lower(x) - y) / blur_px)
    grain = sum(gaussian_filter(rng.normal(size=(height, 2 * width)), scale) * scale for scale in (1.0, 4.0))
    start = round(width / 2 + shift_px)
    grain = texture * grain[:, start : start + width] / grain.std()
    gradient = 30 * (y / height - 0.5) * np.ones_like(x)
    noise = rng.normal(0, 1.5, (height, width, 3))
    cable_colour = np.array(cable) + grain[..., None]
    sky_colour = np.array(sky) - gradient[..., None]
    picture = inside[..., None] * cable_colour + (1 - inside[..., None]) * sky_colour + noise
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)
