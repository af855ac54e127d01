"""The specification of a synthetic survey: frozen records with defaults, units in the names, no reading.

Gives what SPEC.toml may say; :mod:`synth.spec_reader` reads it strictly.  Leaves out what follows from it:
surface, motion, lens formulas and truth have modules of their own.
"""

from dataclasses import dataclass, field
from enum import StrEnum

from pipeline.core.vocabulary import LambdaRadius, TravelDirection


class MaterialKind(StrEnum):
    """What the sheath of the cable is made of."""

    HDPE = "hdpe"
    PAINTED = "painted"


class Output(StrEnum):
    """How the frames of a block are delivered."""

    VIDEO = "video"
    IMAGES = "images"


@dataclass(frozen=True, kw_only=True)
class Station:
    """A place along the cable where the diameter is set and will be asked for.

    Attributes:
        name: unique name.
        position_m: along the axis from the first frame.
        diameter_mm: mean diameter there; None takes the cable's constant diameter (all stations or none).
    """

    name: str
    position_m: float
    diameter_mm: float | None = None


@dataclass(frozen=True, kw_only=True)
class Material:
    """What the surface looks like.  Strengths run from 0 (absent) to 1 (heavy).

    Attributes:
        kind: weathered polyethylene sheath or paint.
        grain: fine natural mottling of the material itself.
        dirt: blotches of soot and dust.
        streaks: marks of running water along the axis.
        scratches: thin scrapes from handling and stay ropes.
        speckle: small specks: lichen, splashes, dust grains.
        texel_mm: side of a texel of the painted-on texture.
    """

    kind: MaterialKind = MaterialKind.HDPE
    grain: float = 0.5
    dirt: float = 0.5
    streaks: float = 0.5
    scratches: float = 0.5
    speckle: float = 0.5
    texel_mm: float = 0.2


@dataclass(frozen=True, kw_only=True)
class Fillet:
    """Two helical ribs, half a turn apart, that break up rain rivulets; right-handed about +y.

    Attributes:
        height_mm: rise of the crest over the sheath.
        width_mm: width of the cosine-squared rib, measured around the circumference.
        pitch_m: length of one turn along the axis.
        angle_deg: azimuth of the first rib at y = 0.
    """

    height_mm: float = 2.0
    width_mm: float = 8.0
    pitch_m: float = 0.6
    angle_deg: float = 30.0


@dataclass(frozen=True, kw_only=True)
class Cable:
    """The body that is measured.

    Attributes:
        diameter_mm: constant mean diameter, used where no station sets one.
        station: stations in the order of position.
        ovality_mm: largest minus smallest diameter of the elliptic cross-section.
        ovality_angle_deg: azimuth of the largest diameter.
        margin_m: cable before the first and behind the last position of the robot.
        material: what it looks like.
        fillet: helical ribs, or None.
    """

    diameter_mm: float = 110.0
    station: tuple[Station, ...] = ()
    ovality_mm: float = 0.0
    ovality_angle_deg: float = 0.0
    margin_m: float = 0.30
    material: Material = field(default_factory=Material)
    fillet: Fillet | None = None


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
        samples: rays per pixel; with motion blur shared out over 8 moments of the open shutter.
        output: video or images.
        video_crf: H.264 quality, 0 (lossless) to 51; lower is better.
        frames_per_second: of the video.
    """

    exposure: float = 1.0
    full_well_e: float = 12000.0
    read_noise_e: float = 4.0
    vignetting: float = 0.15
    motion_blur_mm: float = 0.0
    samples: int = 8
    output: Output = Output.VIDEO
    video_crf: float = 12.0
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
        diameter_given: whether the nominal diameter is stated.
    """

    calibrated: bool = False
    focal_error_percent: float = 0.0
    lambda_given: bool = True
    lambda_error: float = 0.0
    travel_error_percent: float = 0.0
    diameter_given: bool = True


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
