"""The network that is adjusted: stations, the features they share, and who saw what.

Takes the survey and each station's features; gives numbers instead of names.  Leaves out geometry.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.survey_records import SteelSurvey


@dataclass(frozen=True, kw_only=True)
class Network:
    """Stations and named features.

    Attributes:
        stations: names, in the survey's order.
        base: number of the base station.
        names, kinds: of each feature; a name may be used once in each kind.
        station, feature: (n,) int64, of each observation.
        seen: the observations, in their station's frame.
        control: feature number to (place (3,) in the site frame, sigma in metres).
    """

    stations: tuple[str, ...]
    base: int
    names: tuple[str, ...]
    kinds: tuple[FeatureKind, ...]
    station: NDArray[np.int64]
    feature: NDArray[np.int64]
    seen: tuple[Feature, ...]
    control: dict[int, tuple[Array, float]]

    def of_kind(self, kind: FeatureKind) -> NDArray[np.int64]:
        """Numbers of the observations of one kind."""
        return np.flatnonzero([feature.kind is kind for feature in self.seen])

    def points_of(self, station: int) -> dict[int, int]:
        """Feature number to observation number of the points that a station sees."""
        mine = np.flatnonzero(self.station == station)
        return {int(self.feature[n]): int(n) for n in mine if self.seen[n].kind is FeatureKind.POINT}

    def figures_of(self, station: int) -> list[int]:
        """Observation numbers of the axes and planes that a station sees."""
        mine = np.flatnonzero(self.station == station)
        return [int(n) for n in mine if self.seen[n].kind is not FeatureKind.POINT]

    def named_by(self, station: int) -> set[int]:
        """Feature numbers of all that a station sees."""
        return set(self.feature[self.station == station].tolist())

    @property
    def places(self) -> Array:
        """(n, 3) where each observation's feature is in its station's frame."""
        return np.array([feature.place for feature in self.seen]).reshape(-1, 3)

    def largest_sigma_m(self, observations: Sequence[int]) -> float:
        """Largest standard deviation of a coordinate among some point observations."""
        return float(np.sqrt(max(np.diag(self.seen[n].covariance).max() for n in observations)))


def build_network(survey: SteelSurvey, found: Sequence[StationFeatures]) -> Network:
    """Number stations and named features; features without a name tie nothing and are left out.

    Raises:
        StageError: a station has no features, or one name twice; a control target that nobody sees.
    """
    stations = tuple(station.name for station in survey.stations)
    by_station = {features.station: features for features in found}
    numbers: dict[tuple[FeatureKind, str], int] = {}
    station_of, feature_of, seen = [], [], []
    for number, name in enumerate(stations):
        named = [f for f in (by_station[name].features if name in by_station else ()) if f.name]
        _check_names(name, named)
        for feature in named:
            key = (feature.kind, feature.name)
            station_of.append(number)
            feature_of.append(numbers.setdefault(key, len(numbers)))
            seen.append(feature)
    control = {}
    for target in survey.control:
        feature_number = numbers.get((FeatureKind.POINT, target.name))
        if feature_number is None:
            raise StageError(
                "register",
                f"no station sees the control target {target.name}",
                "name it in a station's targets, or leave it out of control",
            )
        control[feature_number] = (np.array(target.position_m), target.sigma_mm / 1000)
    return Network(
        stations=stations,
        base=stations.index(survey.base.name),
        names=tuple(name for _, name in numbers),
        kinds=tuple(kind for kind, _ in numbers),
        station=np.array(station_of, dtype=np.int64),
        feature=np.array(feature_of, dtype=np.int64),
        seen=tuple(seen),
        control=control,
    )


def _check_names(station: str, named: Sequence[Feature]) -> None:
    if not named:
        raise StageError(
            "register",
            f"station {station} has no target that could be named",
            "name its targets by hand, or leave the station out",
        )
    keys = [(feature.kind, feature.name) for feature in named]
    for kind, name in keys:
        if keys.count((kind, name)) > 1:
            raise StageError(
                "register", f'station {station} has the {kind} "{name}" twice', "give each its own name"
            )
