"""What the steel stages hand to each other about stations and the features that tie them together.

Frames of reference, in metres:
    *station*  the scanner's own: origin at its centre, z up where it is levelled.
    *site*     the structure's: z up, x east, y north unless the survey turns north; the base station's frame,
               or that of the control targets.
A pose is always ``site_from_station``: x_site = rotation @ x_station + translation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from pipeline.core.vocabulary import Array


class FeatureKind(StrEnum):
    """What a feature pins down: a place, an axis, a plane."""

    POINT = "point"
    LINE = "line"
    PLANE = "plane"


@dataclass(frozen=True, kw_only=True)
class Feature:
    """A figure fitted to the cloud of one station, or a target named by hand.

    Attributes:
        kind: point (centre of a sphere), line (axis of a cylinder) or plane.
        name: as the survey calls it; "" where nobody has named it yet.
        place: (3,) metres: the centre; the point of the axis or plane nearest the points' centroid.
        direction: (3,) unit vector of the axis or normal; zeros for a point.
        frame: (3, 3) rows u, v, direction: the frame of the covariance; the identity for a point.
        covariance: point (3, 3) of the centre; line (4, 4) of (offset along u, along v, slope towards u,
            towards v); plane (3, 3) of (offset along the normal, slope towards u, towards v).
        radius_m: of the sphere or cylinder; 0 for a plane.
        points: how many points of the cloud it was fitted to; 0 for a target named by hand.
        rms_m: of their distances from the figure.
        reach_m: how far along the axis, or over the plane, points lie about the place; 0 for a point.
    """

    kind: FeatureKind
    name: str
    place: Array
    direction: Array
    frame: Array
    covariance: Array
    radius_m: float
    points: int
    rms_m: float
    reach_m: float = 0.0


@dataclass(frozen=True, kw_only=True)
class StationFeatures:
    """All features of one station, in its own frame."""

    station: str
    features: tuple[Feature, ...]


@dataclass(frozen=True, kw_only=True)
class StationPose:
    """Where a station stood.

    Attributes:
        name: of the station.
        rotation: (3, 3) site_from_station.
        translation: (3,) metres, the scanner's centre in the site frame.
        covariance: (6, 6) of (rotation vector on the left in radians, translation in metres); zero for a
            station that defines the frame.
        among: (n, 6, 6) covariance of the same six with those of each of the n stations, in their order:
            what hangs on several stations must know that their errors are alike.  (0, 6, 6): not known.
    """

    name: str
    rotation: Array
    translation: Array
    covariance: Array
    among: Array = field(default_factory=lambda: np.zeros((0, 6, 6)))


def chosen_poses(poses: Sequence[StationPose], names: Sequence[str]) -> tuple[StationPose, ...]:
    """Some stations, in the order of ``names``, with the covariances among just these."""
    places = {pose.name: number for number, pose in enumerate(poses)}
    index = [places[name] for name in names]
    return tuple(
        replace(poses[n], among=poses[n].among[index] if len(poses[n].among) else poses[n].among)
        for n in index
    )


@dataclass(frozen=True, kw_only=True)
class Plumb:
    """Which way is up, from the compensators of all levelled stations together.

    The site's z is the base station's, or the control targets'; one compensator is off by seconds, and over a
    column's height a second is 5 micrometres a metre.

    Attributes:
        direction: (3,) unit vector upwards, site frame.
        across: (2, 3) unit vectors u, v, level.
        covariance: (2, 2) of the slopes of the direction towards u and v.
        stations: names of the stations.
        with_stations: (n, 6, 2) covariance of each station's errors, as in StationPose, with the slopes.
    """

    direction: Array
    across: Array
    covariance: Array
    stations: tuple[str, ...]
    with_stations: Array

    def chosen(self, names: Sequence[str]) -> Array:
        """(k, 6, 2) the covariances with some stations, in the order of ``names``; zero for unknown ones."""
        places = {name: number for number, name in enumerate(self.stations)}
        nothing = np.zeros((6, 2))
        found = [self.with_stations[places[n]] if n in places else nothing for n in names]
        return np.array(found).reshape(-1, 6, 2)
