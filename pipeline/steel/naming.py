"""Stage *naming*: unnamed targets of all stations matched by their mutual distances, and named.

Takes the features of each station; gives the same with names: T001 and so on for targets that two stations or
more see.  The map of targets grows outward from the base station: each time the station that shares most with
it is added.  Names given by hand are kept; what cannot be matched without doubt stays unnamed.  Leaves out
accuracy: the poses found on the way are thrown away.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.steel.pattern import Fit, find_pattern
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.registration_options import TargetOptions


@dataclass(kw_only=True)
class _Target:
    """A place of the map and who sees it: (station, feature) numbers."""

    places: list[Array]
    seen: list[tuple[int, int]]

    @property
    def place(self) -> Array:
        return np.asarray(np.mean(self.places, axis=0))


def name_features(
    found: Sequence[StationFeatures], base: str, level: bool, options: TargetOptions, emit: Emit
) -> list[StationFeatures]:
    """Name the point features of all stations.

    Args:
        found: features of each station.
        base: the station from which the map grows.
        level: the stations' z axes are plumb.
        options: see there.
        emit: progress.

    Returns:
        The features in the order of ``found``; those without a partner in another station stay unnamed.
    """
    points = [
        [n for n, f in sorted(enumerate(one.features), key=_worth) if f.kind is FeatureKind.POINT]
        for one in found
    ]
    first = next((s for s, one in enumerate(found) if one.station == base), 0)
    targets = [_Target(places=[found[first].features[n].place], seen=[(first, n)]) for n in points[first]]
    waiting = [s for s in range(len(found)) if s != first]
    fits: dict[int, Fit | None] = {}
    while waiting:
        emit(Event(stage="naming", done=len(found) - len(waiting), total=len(found)))
        known = np.array([target.place for target in targets]).reshape(-1, 3)
        for station in waiting:
            if station not in fits:
                places = np.array([found[station].features[n].place for n in points[station]]).reshape(-1, 3)
                fits[station] = find_pattern(places, known, options.match_tolerance_m, level=level)
        station = max(waiting, key=lambda s: (_score(fits[s], options), -s))
        fit = fits[station]
        if fit is None or _score(fit, options) <= 0:
            break
        _grow(targets, found[station].features, points[station], station, fit, options)
        waiting.remove(station)
        # only where the map has grown can a station find more than before
        fits = {s: f for s, f in fits.items() if s != station and not _may_gain(f)}
    emit(Event(stage="naming", done=len(found), total=len(found)))
    return _named(found, targets)


def _worth(item: tuple[int, Feature]) -> float:
    """Best measured first."""
    return float(np.trace(item[1].covariance))


def _score(fit: Fit | None, options: TargetOptions) -> int:
    """How many targets a fit shares with the map; 0 where another place would do nearly as well."""
    if fit is None or fit.count < options.least_common or fit.rival >= fit.count - (fit.count > 4):
        return 0
    return fit.count


def _may_gain(fit: Fit | None) -> bool:
    return fit is None or bool((fit.partner < 0).any())


def _grow(
    targets: list[_Target],
    features: Sequence[Feature],
    numbers: Sequence[int],
    station: int,
    fit: Fit,
    options: TargetOptions,
) -> None:
    """Add a station's sightings; what has no partner becomes a new target, unless it is nearly one."""
    known = np.array([target.place for target in targets])
    for n, partner in zip(numbers, fit.partner.tolist(), strict=True):
        place = fit.rotation @ features[n].place + fit.translation
        if partner >= 0:
            targets[partner].places.append(place)
            targets[partner].seen.append((station, n))
        elif np.linalg.norm(known - place, axis=1).min() > 5 * options.match_tolerance_m:
            targets.append(_Target(places=[place], seen=[(station, n)]))


def _named(found: Sequence[StationFeatures], targets: Sequence[_Target]) -> list[StationFeatures]:
    names = {(s, n): f.name for s, one in enumerate(found) for n, f in enumerate(one.features)}
    taken = {name for name in names.values() if name}
    fresh = (f"T{number:03d}" for number in range(1, 10**6))
    for target in targets:
        if len(target.seen) < 2:
            continue
        given = [names[key] for key in target.seen if names[key]]
        name = given[0] if given else next(name for name in fresh if name not in taken)
        for key in target.seen:
            if not names[key] and not _has(names, key[0], name):
                names[key] = name
    return [
        StationFeatures(
            station=one.station,
            features=tuple(replace(f, name=names[s, n]) for n, f in enumerate(one.features)),
        )
        for s, one in enumerate(found)
    ]


def _has(names: dict[tuple[int, int], str], station: int, name: str) -> bool:
    return any(s == station and given == name for (s, _), given in names.items())
