"""The records of a survey: cable, robot, cameras and their lenses, as the user wrote them down.

Frozen records with units in their names; :meth:`Block.lens` turns a lens as written into a
:class:`~pipeline.core.vocabulary.Lens` once the image size is known.  Leaves out reading and checking the
file (``survey.py``).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import hypot
from pathlib import Path

from pipeline.core import division
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import LambdaRadius, Lens, TravelDirection

FOCAL_SIGMA = 0.03
"""Standard deviation of a focal length that is only a starting value, relative."""

LAMBDA_SIGMA = 0.02
"""Standard deviation of a lambda that is given without one and untrusted, for the half diagonal as radius."""

UNKNOWN_LAMBDA_SIGMA = 0.15
"""Standard deviation of a lambda of which nothing is known, for the half diagonal as radius."""


@dataclass(frozen=True, kw_only=True)
class Station:
    """A place where the diameter is wanted.

    Attributes:
        name: unique label.
        position_m: along the axis from the first frame.
    """

    name: str
    position_m: float = field(metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class Cable:
    """The cable and what is known of it.

    Attributes:
        travel_m: path of the robot between the first and the last frame.
        travel_sigma_mm: standard deviation of the travel, which every diameter inherits in proportion.
        diameter_mm: nominal, narrows the search and never enters a result; None where unknown.
        stations: where diameters are wanted, at least one after reading.
    """

    travel_m: float
    travel_sigma_mm: float = field(default=0.05, metadata={"minimum": 0.0})
    diameter_mm: float | None = field(default=None, metadata={"above": 0.0})
    stations: tuple[Station, ...] = field(default=(), metadata={"key": "station"})


@dataclass(frozen=True, kw_only=True)
class Robot:
    """The robot that carries the cameras.

    Attributes:
        standoff_m: camera centre to cable axis.
        synchronised: all blocks share one clock, frame k of each block is one moment.
    """

    standoff_m: float = field(metadata={"above": 0.0})
    synchronised: bool


@dataclass(frozen=True, kw_only=True)
class LensSpec:
    """A lens as the user wrote it down; with the image size it becomes a :class:`Lens`.

    Attributes:
        focal_px: focal length in pixels; or else
        focal_mm, sensor_width_mm: focal length and width of the sensor.
        principal_point_px: (x, y) from the top-left corner; None is the image centre.
        division_lambda: of the division model; None is unknown, to be estimated.
        lambda_sigma: standard deviation of division_lambda, in the same unit; None is not stated.
        lambda_radius: what the radius is measured in.
        calibrated: focal length and lambda are trusted; else they are starting values.
    """

    focal_px: float | None = field(default=None, metadata={"above": 0.0})
    focal_mm: float | None = field(default=None, metadata={"above": 0.0})
    sensor_width_mm: float | None = field(default=None, metadata={"above": 0.0})
    principal_point_px: tuple[float, float] | None = field(default=None, metadata={"minimum": 0.0})
    division_lambda: float | None = None
    lambda_sigma: float | None = field(default=None, metadata={"above": 0.0})
    lambda_radius: LambdaRadius = LambdaRadius.HALF_DIAGONAL
    calibrated: bool = False

    def lens(self, width_px: int, height_px: int, key: str = "block.lens") -> Lens:
        """Give the lens for images of this size; an unknown lambda starts at zero.

        Args:
            width_px, height_px: image size.
            key: full name of this table, for messages.

        Raises:
            StageError: the principal point lies outside the image, or the lens folds inside it.
        """
        centre = self.principal_point_px or (width_px / 2, height_px / 2)
        if not (centre[0] < width_px and centre[1] < height_px):
            raise StageError(
                "survey",
                f"{key}.principal_point_px = [{centre[0]:g}, {centre[1]:g}] lies outside the image of "
                f"{width_px} x {height_px}",
                "give it in pixels from the top-left corner",
            )
        lens = Lens(
            width_px=width_px,
            height_px=height_px,
            focal_px=self._focal_px(width_px),
            principal_point_px=centre,
            division_lambda=self.division_lambda or 0.0,
            lambda_radius=self.lambda_radius,
        )
        try:
            division.check(lens)
        except StageError as error:
            raise StageError("survey", f"{key}: {error.cause}", error.remedy) from error
        return replace(
            lens,
            focal_sigma_px=0.0 if self.calibrated else FOCAL_SIGMA * lens.focal_px,
            lambda_sigma=self._lambda_sigma(lens),
        )

    def _focal_px(self, width_px: int) -> float:
        if self.focal_px is not None:
            return self.focal_px
        if self.focal_mm is None or self.sensor_width_mm is None:
            raise StageError("survey", "a lens has no focal length", "give focal_px")
        return self.focal_mm / self.sensor_width_mm * width_px

    def _lambda_sigma(self, lens: Lens) -> float:
        """In the lens's own unit, as lambda itself."""
        known = self.division_lambda is not None
        if known and self.calibrated:
            return 0.0
        if known and self.lambda_sigma is not None:
            return self.lambda_sigma
        # lambda r^2 / unit^2 is the same whatever the unit: carry the sigma over from the half diagonal
        per_half_diagonal = (division.radius_unit_px(lens) / (hypot(lens.width_px, lens.height_px) / 2)) ** 2
        return (LAMBDA_SIGMA if known else UNKNOWN_LAMBDA_SIGMA) * per_half_diagonal


@dataclass(frozen=True, kw_only=True)
class Block:
    """One camera and the strip of images that it took.

    Attributes:
        name: unique, usable as the name of a folder.
        source: absolute path of the video or the folder of images, or a glob pattern.
        angle_deg: place of the camera around the axis, right-hand rule about +y.
        travel_in_image: image direction in which +y points.
        pos: absolute path of the measured POS, or None for the constructed one.
        ordered: the images' names follow the travel at even steps; else order and places are found from the
            pictures.
        lens_spec: the lens as written (``[block.lens]``).
    """

    name: str
    source: Path
    angle_deg: float
    travel_in_image: TravelDirection
    pos: Path | None = None
    ordered: bool = True
    lens_spec: LensSpec = field(metadata={"key": "lens"})

    def lens(self, width_px: int, height_px: int) -> Lens:
        """Give the block's lens for images of this size; see :meth:`LensSpec.lens`."""
        return self.lens_spec.lens(width_px, height_px, key=f"block[{self.name}].lens")


@dataclass(frozen=True, kw_only=True)
class Survey:
    """The whole survey.

    Attributes:
        format: version of the file's layout, 1.
        name: of the cable.
        cable, robot: what is known of them.
        blocks: one a camera, at least one.
        options: stage to key to value, as written in ``[options.STAGE]``.
    """

    format: int
    name: str
    cable: Cable
    robot: Robot
    blocks: tuple[Block, ...] = field(metadata={"key": "block"})
    options: Mapping[str, object] = field(default_factory=dict)

    def stage_options(self, stage: str) -> Mapping[str, object]:
        """The table ``[options.STAGE]``, empty where the file has none."""
        table = self.options.get(stage, {})
        return table if isinstance(table, Mapping) else {}
