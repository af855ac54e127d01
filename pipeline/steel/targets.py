"""Stage *targets*: the features of one station, found and fitted in its cloud.

Takes the station's points; gives sphere targets, planes and axes without names.  Leaves out naming them
(``naming.py``, ``figures.py``) and targets named by hand (``target_table.py``).
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.events import Emit, Event, part
from pipeline.steel.axes import find_axes
from pipeline.steel.clouds import StationCloud, station_points
from pipeline.steel.plane_fit import FittedPlane
from pipeline.steel.planes import find_planes
from pipeline.steel.range_image import range_image
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.sphere_fit import FittedSphere
from pipeline.steel.spheres import find_spheres
from pipeline.steel.survey_records import SteelSurvey


def find_targets(
    points: NDArray[np.float32], station: str, survey: SteelSurvey, options: TargetOptions, emit: Emit
) -> StationFeatures:
    """Find the sphere targets in a station's points (n, 3), station frame, metres.

    The survey gives the radius, the scanner's noise and the ball nodes, which are no targets; without a
    radius nothing is looked for.  The nearest target stands first.
    """
    radius_mm = survey.targets.radius_mm
    if radius_mm is None:
        return StationFeatures(station=station, features=())
    balls = tuple(diameter / 2000 for diameter in survey.structure.ball_diameters_mm)
    spheres = find_spheres(
        range_image(points), radius_mm / 1000, survey.scanner, emit, station, other_radii_m=balls
    )
    good = [
        sphere
        for sphere in spheres
        if sphere.points >= options.least_points and np.linalg.norm(sphere.centre) <= options.farthest_m
    ]
    emit(Event(stage="targets", done=100, total=100, block=station))
    return StationFeatures(
        station=station, features=tuple(_feature(sphere, radius_mm / 1000) for sphere in good)
    )


def find_figures(
    cloud: StationCloud, survey: SteelSurvey, options: TargetOptions, scratch: Path, emit: Emit
) -> tuple[Feature, ...]:
    """Find planes and axes in a station's cloud, as far as the options want them.

    Args:
        cloud: of the station.
        survey: scanner and nominal diameters.
        options: see there.
        scratch: an existing folder for passing files.
        emit: progress.
    """
    found: list[Feature] = []
    if options.planes:
        first = part(emit, 0.0, 0.3 if options.axes else 1.0)

        def tick(done: int, total: int) -> None:
            first(Event(stage="targets", done=done, total=total, block=cloud.station))

        planes = find_planes(
            station_points(cloud.path),
            survey.scanner,
            options.least_plane_m2,
            options.figure_sigma_mm / 1000,
            tick,
        )
        found += [_plane(plane) for plane in planes]
    if options.axes:
        second = part(emit, 0.3 if options.planes else 0.0, 1.0)
        found += find_axes(cloud.path, cloud.station, survey, options, scratch, second)
    return tuple(found)


def _plane(plane: FittedPlane) -> Feature:
    return Feature(
        kind=FeatureKind.PLANE,
        name="",
        place=plane.place,
        direction=plane.frame[2],
        frame=plane.frame,
        covariance=plane.covariance,
        radius_m=0.0,
        points=plane.points,
        rms_m=plane.rms_m,
        reach_m=plane.reach_m,
    )


def _feature(sphere: FittedSphere, radius_m: float) -> Feature:
    return Feature(
        kind=FeatureKind.POINT,
        name="",
        place=sphere.centre,
        direction=np.zeros(3),
        frame=np.eye(3),
        covariance=sphere.covariance,
        radius_m=radius_m,
        points=sphere.points,
        rms_m=sphere.rms_m,
    )
