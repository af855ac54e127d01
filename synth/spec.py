"""The specification of a synthetic survey: frozen records with defaults, units in the names, no reading.

Gives what SPEC.toml may say; :mod:`synth.spec_reader` reads it strictly.  Leaves out what follows from it:
surface, motion, lens formulas and truth have modules of their own.
"""

from dataclasses import dataclass, field
from enum import StrEnum

from pipeline.core.vocabulary import LambdaRadius, TravelDirection
from synth.spec_cable import Cable as Cable
from synth.spec_cable import Defect as Defect
from synth.spec_cable import DefectKind as DefectKind
from synth.spec_cable import Fillet as Fillet
from synth.spec_cable import Material as Material
from synth.spec_cable import MaterialKind as MaterialKind
from synth.spec_cable import Station as Station


class Output(StrEnum):
    """How the frames of a block are delivered."""

    VIDEO = "video"
    IMAGES = "images"


@dataclass(frozen=True, kw_only=True)
class Robot:
    """The ring of cameras and its motion.

    Attributes:
        cameras: number of cameras at equal angles from 0, named Block1 to BlockN.
        angles_deg: explicit azimuths instead of equal ones; its length then is the number of cameras.
        standoff_m: camera centre to cable axis.
        travel_m: path of the ring between first and last frame.
        frames: frames per camera.
        travel_in_image: image direction in which +y points.
        synchronised: one clock and one motion for all cameras; false: every camera has a pass of its own.
        sway_deg: RMS of each of the ring's three rotations about the cable frame's axes, over the frames.
        sway_mm: RMS of each of the ring's two displacements across the cable (x and z), over the frames.
        speed_wander_mm: RMS of the ring's deviation from even travel along y; zero at first and last frame.
        mounting_deg: standard deviation of each camera's constant yaw, pitch and roll error.
        mounting_mm: standard deviation of each camera's constant displacement along the cable frame's axes.
    """

    cameras: int = 4
    angles_deg: tuple[float, ...] = ()
    standoff_m: float = 0.30
    travel_m: float = 0.46
    frames: int = 24
    travel_in_image: TravelDirection = TravelDirection.RIGHT
    synchronised: bool = True
    sway_deg: float = 0.0
    sway_mm: float = 0.0
    speed_wander_mm: float = 0.0
    mounting_deg: float = 0.0
    mounting_mm: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Light:
    """What lights the cable and what stands behind it.

    Attributes:
        lamp_strength: of the lamps that travel with the ring, one half-way between neighbouring cameras;
            relative to the usual.
        daylight: even light from all around, which does not travel, relative to white.
        sky: brightness of the plain gradient behind the cable; lights nothing.
    """

    lamp_strength: float = 1.0
    daylight: float = 0.15
    sky: float = 0.2


@dataclass(frozen=True, kw_only=True)
class LensSpec:
    """The true lens, the same for every camera but for the spread.

    Attributes:
        focal_px, width_px, height_px: focal length and image size.
        principal_point_px: (x, y) from the top-left corner; None is the image centre.
        division_lambda, lambda_radius: distortion, equation (15) of the cable paper.
        focal_spread_percent: standard deviation of the cameras' own focal lengths.
    """

    focal_px: float = 720.0
    width_px: int = 960
    height_px: int = 600
    principal_point_px: tuple[float, float] | None = None
    division_lambda: float = 0.0
    lambda_radius: LambdaRadius = LambdaRadius.HALF_DIAGONAL
    focal_spread_percent: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """From light to files.

    Attributes:
        exposure: factor on the light; 1 puts a mid-grey surface at mid-grey.
        full_well_e: photo-electrons at white, sets the photon noise; 0 is a noiseless sensor.
        read_noise_e: standard deviation of the read-out, electrons.
        vignetting: loss of light in the image corner, 0 to 1.
        motion_blur_mm: path of the ring while the shutter is open, centred on the moment of the frame.
        readout_share: rolling shutter: share of the frame interval between the first and the last row of the
            image; the moment of the frame is that of the middle row.
        samples: rays per pixel; with motion blur shared out over the moments of the open shutter.
        output: video or images.
        video_crf: H.264 quality, 0 (lossless) to 51; lower is better.
        video_mbit_per_s: H.264 at this bit rate instead of constant quality; 0 leaves it to video_crf.
        frames_per_second: of the video.
    """

    exposure: float = 1.0
    full_well_e: float = 12000.0
    read_noise_e: float = 4.0
    vignetting: float = 0.15
    motion_blur_mm: float = 0.0
    readout_share: float = 0.0
    samples: int = 8
    output: Output = Output.VIDEO
    video_crf: float = 12.0
    video_mbit_per_s: float = 0.0
    frames_per_second: int = 10


@dataclass(frozen=True, kw_only=True)
class SurveyClaim:
    """What survey.toml tells the pipeline, which need not be the truth.

    Attributes:
        calibrated: whether focal length and lambda are called trusted.
        focal_error_percent: stated focal length is off by this much.
        lambda_given: whether lambda is stated at all.
        lambda_error: added to the stated lambda.
        travel_error_percent: stated travel is off by this much.
        travel_sigma_mm: stated standard deviation of the travel; 0 states none.
        diameter_given: whether the nominal diameter is stated.
        principal_point_error_percent: stated principal point is off by this much of the image width, in the
            image direction (0.8, 0.6).
        lost_blocks: blocks that are left out, as if their video had been lost; truth.json keeps them.
    """

    calibrated: bool = False
    focal_error_percent: float = 0.0
    lambda_given: bool = True
    lambda_error: float = 0.0
    travel_error_percent: float = 0.0
    travel_sigma_mm: float = 0.0
    diameter_given: bool = True
    principal_point_error_percent: float = 0.0
    lost_blocks: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Spec:
    """A whole synthetic survey.

    Attributes:
        name: of the survey.
        seed: of every random draw: texture, sway, mountings, noise.
        depth_frames: frames of which OpenEXR depth is written too.
        cable, robot, light, lens, sensor, survey: the parts.
    """

    name: str = "synthetic"
    seed: int = 1
    depth_frames: tuple[int, ...] = ()
    cable: Cable = field(default_factory=Cable)
    robot: Robot = field(default_factory=Robot)
    light: Light = field(default_factory=Light)
    lens: LensSpec = field(default_factory=LensSpec)
    sensor: Sensor = field(default_factory=Sensor)
    survey: SurveyClaim = field(default_factory=SurveyClaim)

    @property
    def angles_deg(self) -> tuple[float, ...]:
        """Azimuth of every camera, in the order of the blocks."""
        if self.robot.angles_deg:
            return self.robot.angles_deg
        return tuple(360.0 * i / self.robot.cameras for i in range(self.robot.cameras))

    @property
    def blocks(self) -> tuple[str, ...]:
        """Names of the blocks, Block1 to BlockN."""
        return tuple(f"Block{i + 1}" for i in range(len(self.angles_deg)))
