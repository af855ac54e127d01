"""A flight above the frame: the records of the photos."""

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Photos:
    """Photos by a calibrated camera (a pinhole) carried above the frame.

    Attributes:
        count: along x and across (y); the flight goes there and back.
        height_m: of the camera over the top chord.
        reach: the outermost photos are taken over this share of the way from the middle to the frame's edge.
        converge: 0 looks plumb down, 1 at the middle of the bottom chord.
        jitter_m, sway_deg: standard deviation of each coordinate and of each angle from the plan.
        width_px, height_px, focal_px: of the camera.
        focal_error_percent: of what survey.toml states of it.
        samples: rays per pixel.
        read_noise_e: of the sensor.
    """

    count: tuple[int, int] = field(default=(4, 3), metadata={"minimum": 1})
    height_m: float = field(default=5.0, metadata={"above": 0.5})
    reach: float = field(default=0.9, metadata={"minimum": 0.0})
    converge: float = field(default=0.4, metadata={"minimum": 0.0, "maximum": 1.0})
    jitter_m: float = field(default=0.15, metadata={"minimum": 0.0})
    sway_deg: float = field(default=2.0, metadata={"minimum": 0.0})
    width_px: int = field(default=960, metadata={"minimum": 64})
    height_px: int = field(default=600, metadata={"minimum": 64})
    focal_px: float = field(default=800.0, metadata={"above": 0.0})
    focal_error_percent: float = 0.0
    samples: int = field(default=8, metadata={"minimum": 1})
    read_noise_e: float = field(default=4.0, metadata={"minimum": 0.0})
