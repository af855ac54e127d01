"""Axes of columns and long rods in the cloud of one station.

Takes the station's points; gives the axes of the cylinders that the search for members finds in them, with
what one station can know of each.  Leaves out the search and the fits themselves (``members.py``).

What the noise of the points leaves uncertain is the least of it.  One station sees an arc, and along its
line of sight an axis is the difference of two large things, the surface's place and the radius: a member
out of round by a tenth of a millimetre moves the axis of a 130 degree arc three times as far, and its
points still lie on a cylinder.  That is put into the covariance, in the two directions by what each suffers
(``_by_roundness``), and so is what all points of a station share (an error of the range, paint).
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.steel.member_records import MemberOptions, NominalSizes, Rod
from pipeline.steel.members import find_members
from pipeline.steel.records import Feature, FeatureKind, StationPose
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.survey_records import SteelSurvey
from pipeline.steel.tile_records import TileOptions
from pipeline.steel.tiles import build_tiles

STEPS = 201
"""Places on an arc that a form is fitted at."""
HARMONICS = (2, 3)
"""Waves around the circumference: oval, three-cornered."""


def find_axes(
    cloud: Path, station: str, survey: SteelSurvey, options: TargetOptions, scratch: Path, emit: Emit
) -> tuple[Feature, ...]:
    """Find axes in a station's points, the longest first.

    Args:
        cloud: .npy, float32 (n, 3), metres, station frame.
        station: its name.
        survey: scanner, and nominal diameters where they are known.
        options: see there.
        scratch: folder that may be written to; left as it was.
        emit: progress, as part of the stage *targets*.
    """

    def tell(event: Event) -> None:
        emit(Event(stage="targets", done=event.done, total=event.total, block=station))

    members = MemberOptions(
        range_sigma_mm=survey.scanner.range_sigma_mm,
        angle_sigma_arcsec=survey.scanner.angle_sigma_arcsec,
        least_length_m=options.least_axis_m,
    )
    tiles = TileOptions(farthest_m=options.axes_within_m)
    known = survey.structure
    nominal = NominalSizes(
        rods_mm=known.rod_diameters_mm, balls_mm=known.ball_diameters_mm, columns_mm=known.column_diameters_mm
    )
    here = StationPose(name=station, rotation=np.eye(3), translation=np.zeros(3), covariance=np.zeros((6, 6)))
    with TemporaryDirectory(dir=scratch, prefix="axes-") as folder:
        try:
            dropped = build_tiles([(station, cloud, here)], tiles, Path(folder) / "tiles", tell)
            found = find_members(dropped, nominal, members, tell)
        except StageError:  # nothing round within reach
            return ()
    axes = [axis_feature(rod, members.rim_deg, options) for rod in (*found.columns, *found.rods)]
    return tuple(sorted(axes, key=lambda axis: -axis.reach_m))


def axis_feature(rod: Rod, rim_deg: float, options: TargetOptions) -> Feature:
    """The axis of a rod that one station, at the origin of its frame, has measured."""
    d, half = rod.direction, rod.length_m / 2
    u = rod.frame[0] - (rod.frame[0] @ d) * d
    u /= np.linalg.norm(u)
    frame = np.stack([u, np.cross(d, u), d])
    common2 = (options.figure_sigma_mm / 1000) ** 2
    covariance = rod.noise_covariance[:4, :4] + common2 * np.diag([1, 1, half**-2, half**-2])
    towards = frame[:2] @ -rod.place
    towards /= max(float(np.linalg.norm(towards)), 1e-9)
    turn = np.stack([towards, [-towards[1], towards[0]]], axis=1)
    covariance[:2, :2] += turn @ _by_roundness(rim_deg, options.roundness_share * rod.radius_m) @ turn.T
    return Feature(
        kind=FeatureKind.LINE,
        name="",
        place=rod.place,
        direction=d,
        frame=frame,
        covariance=covariance,
        radius_m=rod.radius_m,
        points=rod.points,
        rms_m=rod.rms_m,
        reach_m=half,
    )


def _by_roundness(rim_deg: float, wave_m: float) -> Array:
    """(2, 2) covariance, towards the scanner and across, of a centre fitted to the arc that one station sees.

    Args:
        rim_deg: the arc reaches so far to both sides.
        wave_m: standard deviation of each wave about the circumference.
    """
    # rays are even across the width, not around the arc; a range counts as its ray does, not as its height
    across = np.linspace(-1, 1, STEPS) * np.sin(np.radians(rim_deg))
    facing = np.sqrt(1 - across**2)
    angle = np.arcsin(across)
    jacobian = np.column_stack([np.ones(STEPS), across / facing, 1 / facing])
    waves = np.column_stack([turn(k * angle) / facing for k in HARMONICS for turn in (np.cos, np.sin)])
    moved = np.linalg.lstsq(jacobian, waves, rcond=None)[0][:2]
    # either phase is as likely
    covariance: Array = wave_m**2 / 2 * moved @ moved.T
    return covariance
