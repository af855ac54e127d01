"""What a surveyor notes by hand: the targets that a station sees, with the noise of one sighting each.

Gives the rows of the targets' lists, and which gross errors they hold; leaves out files.
"""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from synth.scan.frame import Frame
from synth.scan.hits import HIT
from synth.scan.layout import Layout, Pose
from synth.scan.primitives import World, build_occluders
from synth.scan.spec import STAGE, Misnamed, Scanner, ScanSpec

LIST_SEED = 231
DIRECT_M = 0.01


@dataclass(frozen=True, kw_only=True)
class Sighting:
    """One row: the ``name`` noted, the ``true`` one, the ``place`` measured: (3,) metres, station frame."""

    name: str
    true: str
    place: Array
    sigma_mm: float


def station_lists(spec: ScanSpec, frame: Frame, layout: Layout) -> tuple[tuple[Sighting, ...], ...]:
    """The lists of all stations, in their order.

    Raises:
        StageError: a station sees fewer targets than ``targets.least``, or a misnaming is impossible.
    """
    occluders = build_occluders(spec, frame)
    lists = [_list(spec, layout, occluders, number) for number in range(len(layout.stations))]
    _check_moves(layout, lists)
    for misnamed in spec.gross.misnamed:
        numbers = [n for n, station in enumerate(layout.stations) if station.name == misnamed.station]
        if not numbers:
            raise StageError(
                STAGE, f"gross.misnamed names {misnamed.station}", f"use S01 to {layout.stations[-1].name}"
            )
        lists[numbers[0]] = _misname(misnamed, lists[numbers[0]], layout, numbers[0])
    return tuple(lists)


def _check_moves(layout: Layout, lists: list[tuple[Sighting, ...]]) -> None:
    """A move that is seen from one side only is no error: nothing contradicts it."""
    for name, (first, _) in layout.moves.items():
        seen = [any(sighting.true == name for sighting in sightings) for sightings in lists]
        if not (any(seen[:first]) and any(seen[first:])):
            stations = ", ".join(s.name for s, sees in zip(layout.stations, seen, strict=True) if sees)
            raise StageError(
                STAGE,
                f"{name} moves before {layout.stations[first].name} but is seen only from {stations}",
                "choose a from_station between two of these",
            )


def _list(spec: ScanSpec, layout: Layout, occluders: World, number: int) -> tuple[Sighting, ...]:
    station = layout.stations[number]
    targets = [layout.target_at(target, number) for target in layout.targets]
    places = np.array([target.centre for target in targets]).reshape(-1, 3)
    in_station = (places - station.centre) @ station.rotation
    away = np.linalg.norm(in_station, axis=1)
    near = np.flatnonzero((away <= spec.targets.range_m) & (away >= spec.scanner.min_range_m))
    seen = near[_clear(occluders, station, in_station[near], spec.targets.range_m)]
    chosen = sorted(seen[np.argsort(away[seen], kind="stable")][: spec.targets.nearest])
    if len(chosen) < spec.targets.least:
        raise StageError(
            STAGE,
            f"station {station.name} sees {len(chosen)} targets, targets.least is {spec.targets.least}",
            "give more targets or a longer targets.range_m",
        )
    rng = np.random.default_rng([spec.seed, LIST_SEED, number])
    return tuple(
        Sighting(
            name=targets[i].name,
            true=targets[i].name,
            place=_sighted(in_station[i], spec.scanner, rng),
            sigma_mm=_sigma_mm(float(away[i]), spec.scanner),
        )
        for i in chosen
    )


def _clear(occluders: World, station: Pose, places: Array, reach_m: float) -> Array:
    """(n,) which places the station sees."""
    away = np.linalg.norm(places, axis=1)
    directions = places / away[:, None]
    world = occluders.seen_from(station.rotation, station.centre)
    free = np.ones(len(places), bool)
    for kind, hit in HIT.items():
        for surface in getattr(world, kind):
            if kind != "cylinder" or _horizontal_m(surface) <= reach_m:
                free &= hit(surface, directions).range_m > away - DIRECT_M
    return free


def _horizontal_m(cylinder: Array) -> float:
    """How far a column stands."""
    return float(np.linalg.norm((cylinder[:2] + cylinder[3:5]) / 2.0)) - float(cylinder[6]) - 1.0


def _sighted(place: Array, scanner: Scanner, rng: np.random.Generator) -> Array:
    """The place as range, azimuth and elevation with their noise."""
    azimuth, aside = math.atan2(place[1], place[0]), math.hypot(place[0], place[1])
    elevation, away = math.atan2(place[2], aside), math.hypot(aside, place[2])
    sigma = math.radians(scanner.angle_sigma_arcsec / 3600.0)
    noise = rng.standard_normal(3)
    away += scanner.range_sigma_mm / 1000.0 * noise[0]
    azimuth, elevation = azimuth + sigma * noise[1], elevation + sigma * noise[2]
    flat = away * math.cos(elevation)
    return np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), away * math.sin(elevation)])


def _sigma_mm(away_m: float, scanner: Scanner) -> float:
    """Mean over the three coordinates."""
    across_mm = 1000.0 * away_m * math.radians(scanner.angle_sigma_arcsec / 3600.0)
    return math.sqrt((scanner.range_sigma_mm**2 + 2.0 * across_mm**2) / 3.0)


def _misname(
    misnamed: Misnamed, sightings: tuple[Sighting, ...], layout: Layout, number: int
) -> tuple[Sighting, ...]:
    listed = [sighting.true for sighting in sightings]
    true = misnamed.target or listed[len(listed) // 2]
    if true not in listed:
        raise StageError(STAGE, f"{misnamed.station} does not see {true}", f"name one of {', '.join(listed)}")
    others = [target for target in layout.targets if target.name not in listed]
    if misnamed.called is None:
        if not others:
            raise StageError(STAGE, f"{misnamed.station} sees every target", "state gross.misnamed.called")
        centre = layout.stations[number].centre
        called = min(others, key=lambda target: float(np.linalg.norm(target.centre - centre))).name
    else:
        called = misnamed.called
    if called in listed:
        raise StageError(STAGE, f"{misnamed.station} lists {called} already", "choose another wrong name")
    return tuple(
        Sighting(name=called, true=true, place=s.place, sigma_mm=s.sigma_mm) if s.true == true else s
        for s in sightings
    )
