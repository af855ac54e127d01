"""A survey small enough to be refused in a second: a textured cylinder, ray-traced in closed form.

Two cameras of five frames of 160 x 100, distortion-free, their survey.toml beside them.  Good input: each
test spoils one thing.
"""

from math import cos, pi, radians, sin
from pathlib import Path

import av
import cv2
import numpy as np

WIDTH, HEIGHT, FOCAL_PX = 160, 100, 120.0
RADIUS_M, STANDOFF_M, TRAVEL_M, FRAMES = 0.055, 0.30, 0.06, 5

SURVEY = f"""format = 1
name = "tiny"

[cable]
travel_m = {TRAVEL_M}
diameter_mm = {2000 * RADIUS_M:g}
[[cable.station]]
name = "A"
position_m = 0.02
[[cable.station]]
name = "B"
position_m = 0.04

[robot]
standoff_m = {STANDOFF_M}
synchronised = true

[[block]]
name = "Block1"
source = "block1.mp4"
angle_deg = 0.0
travel_in_image = "right"
[block.lens]
focal_px = {FOCAL_PX}
division_lambda = 0.0
calibrated = true

[[block]]
name = "Block2"
source = "block2.mp4"
angle_deg = 90.0
travel_in_image = "right"
[block.lens]
focal_px = {FOCAL_PX}
division_lambda = 0.0
calibrated = true
"""


def sky(seed=0):
    """A picture without a cable: a gradient with the noise of a sensor, (h, w, 3) uint8."""
    gradient = np.linspace(225.0, 170.0, HEIGHT)[:, None, None] * np.array([1.0, 0.95, 0.9])
    noise = np.random.default_rng(seed).normal(0.0, 2.0, (HEIGHT, WIDTH, 3))
    return np.clip(gradient + noise, 0, 255).astype(np.uint8)


def view(azimuth_deg, y_m):
    """What the camera at this azimuth and place sees of the cable before the sky, (h, w, 3) uint8."""
    a = radians(azimuth_deg)
    forward, right = np.array([-cos(a), 0.0, sin(a)]), np.array([0.0, 1.0, 0.0])
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT) + 0.5 - HEIGHT / 2)
    rays = (x[..., None] * right + y[..., None] * np.cross(forward, right)) / FOCAL_PX + forward
    centre = np.array([STANDOFF_M * cos(a), y_m, -STANDOFF_M * sin(a)])
    square, half, rest = (
        np.sum(rays[..., ::2] ** 2, axis=-1),
        rays[..., ::2] @ centre[::2],
        STANDOFF_M**2 - RADIUS_M**2,
    )
    inner = half**2 - square * rest
    hit = inner > 0
    near = centre + rays * ((-half - np.sqrt(np.where(hit, inner, 0.0))) / square)[..., None]
    row = (np.arctan2(-near[..., 2], near[..., 0]) / (2 * pi) % 1 * (TEXTURE.shape[0] - 1)).astype(np.float32)
    column = ((near[..., 1] + 0.2) / 0.5 * (TEXTURE.shape[1] - 1)).astype(np.float32)
    seen = cv2.remap(TEXTURE, column, row, cv2.INTER_LINEAR)
    return np.where(hit[..., None], seen[..., None], sky(seed=round(1e4 * y_m)))


def views(azimuth_deg, count=FRAMES):
    return [view(azimuth_deg, y_m) for y_m in np.linspace(0.0, TRAVEL_M, count)]


def write_video(path, images):
    """H.264 with its index in front, so that a cut-off end still opens."""
    with av.open(str(path), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=10, options={"crf": "12"})
        stream.width, stream.height, stream.pix_fmt = images[0].shape[1], images[0].shape[0], "yuv420p"
        for image in images:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="bgr24")))
        container.mux(stream.encode())


def write_survey(folder: Path):
    """Fill the folder with the good survey; gives its survey.toml."""
    for number, azimuth_deg in enumerate((0.0, 90.0), start=1):
        write_video(folder / f"block{number}.mp4", views(azimuth_deg))
    (folder / "survey.toml").write_text(SURVEY)
    return folder / "survey.toml"


def _texture():
    rng = np.random.default_rng(5)
    coarse = cv2.resize(rng.uniform(30, 120, (90, 130)).astype(np.float32), (1300, 900))
    return np.clip(coarse + rng.normal(0, 6, coarse.shape), 0, 255).astype(np.uint8)


TEXTURE = _texture()
"""Grey values over azimuth (rows, a full turn) and place along the cable (columns, -0.2 to 0.3 m)."""
