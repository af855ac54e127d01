"""Where stations and targets truly are, in the hall's frame: seeded, clear of columns and of each other."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from synth.scan.frame import Frame, plan_m
from synth.scan.spec import STAGE, Moved, ScanSpec

STATION_SEED, TARGET_SEED, MOVE_SEED = 211, 212, 213
TRIES = 200
HEIGHT_SPREAD_M = 0.1
MAGNET_M = 0.03  # between a column's steel and the sphere it carries
TARGET_CLEAR_M = 0.3


@dataclass(frozen=True, kw_only=True)
class Pose:
    """A station: hall_from_station rotation (3, 3), and the scanner's centre (3,) in the hall."""

    name: str
    rotation: Array
    centre: Array


@dataclass(frozen=True, kw_only=True)
class Target:
    """A sphere: its centre (3,), and the axis (3,) of the column that carries it (None: on a stand)."""

    name: str
    centre: Array
    column: Array | None = None


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Stations in the order of the walk, and the targets as they stood at the first of them."""

    stations: tuple[Pose, ...]
    targets: tuple[Target, ...]
    moves: dict[str, tuple[int, Array]]

    def target_at(self, target: Target, station: int) -> Target:
        """The target as the station of this number (from 0) finds it."""
        first, by = self.moves.get(target.name, (len(self.stations), np.zeros(3)))
        moved = station >= first
        return Target(name=target.name, centre=target.centre + by, column=target.column) if moved else target


def build_layout(spec: ScanSpec, frame: Frame) -> Layout:
    """Place targets, then stations.

    Raises:
        StageError: no room is left, or a gross error names what is not there.
    """
    targets = _targets(spec, frame)
    stations = _stations(spec, frame, targets)
    moves = {
        moved.target: _move(spec, moved, i, targets, len(stations))
        for i, moved in enumerate(spec.gross.moved)
    }
    return Layout(stations=stations, targets=targets, moves=moves)


def _move(
    spec: ScanSpec, moved: Moved, number: int, targets: tuple[Target, ...], stations: int
) -> tuple[int, Array]:
    if moved.target not in [target.name for target in targets]:
        raise StageError(STAGE, f"gross.moved names {moved.target}", f"use T01 to {targets[-1].name}")
    if moved.from_station > stations:
        raise StageError(
            STAGE, f"gross.moved[{moved.target}].from_station is {moved.from_station}", "lower it"
        )
    azimuth = np.random.default_rng([spec.seed, MOVE_SEED, number]).uniform(0.0, 2.0 * math.pi)
    return moved.from_station - 1, moved.by_mm / 1000.0 * np.array(
        [math.cos(azimuth), math.sin(azimuth), 0.0]
    )


def _targets(spec: ScanSpec, frame: Frame) -> tuple[Target, ...]:
    """Stated ones first, then stands, then those on columns."""
    wanted, rng = spec.targets, np.random.default_rng([spec.seed, TARGET_SEED])
    found = [Target(name="", centre=np.array(place)) for place in wanted.at_m]
    for place in _grid(spec, wanted.stands):
        for trial in range(TRIES):
            at = place + _widened(trial, wanted.jitter_m) * rng.uniform(-1.0, 1.0, 2)
            if _clear_m(spec, frame, found, at) > TARGET_CLEAR_M and _off_stated_m(spec, at) > 0.0:
                break
        else:
            raise StageError(STAGE, f"no room for a target's stand near {place}", "change targets.stands")
        found.append(Target(name="", centre=np.array([*at, rng.uniform(*wanted.heights_m)])))
    found += [_on_column(spec, frame, rng, number) for number in range(wanted.on_columns)]
    digits = max(2, len(str(len(found))))
    return tuple(
        Target(name=f"T{number:0{digits}}", centre=target.centre, column=target.column)
        for number, target in enumerate(found, start=1)
    )


def _on_column(spec: ScanSpec, frame: Frame, rng: np.random.Generator, number: int) -> Target:
    """On the side that looks at the hall, a quarter turn either way."""
    column = frame.columns[number % len(frame.columns)]
    height = rng.uniform(*spec.targets.heights_m)
    share = (height - column.foot[2]) / (column.head[2] - column.foot[2])
    axis = column.foot + share * (column.head - column.foot)
    to_middle = plan_m(spec.structure) / 2.0 - axis[:2]
    azimuth = math.atan2(to_middle[1], to_middle[0]) + rng.uniform(-math.pi / 4.0, math.pi / 4.0)
    reach_m = column.radius_m + MAGNET_M + spec.targets.radius_mm / 1000.0
    return Target(
        name="", centre=axis + reach_m * np.array([math.cos(azimuth), math.sin(azimuth), 0.0]), column=axis
    )


def _stations(spec: ScanSpec, frame: Frame, targets: tuple[Target, ...]) -> tuple[Pose, ...]:
    wanted, rng = spec.stations, np.random.default_rng([spec.seed, STATION_SEED])
    grid, stated = _grid(spec, wanted.count), [np.array(place) for place in wanted.at_m]
    places = grid + stated
    digits = max(2, len(str(len(places))))
    found = []
    for number, place in enumerate(places, start=1):
        jitter_m = wanted.jitter_m if number <= len(grid) else 0.0
        for trial in range(TRIES):
            at = place + _widened(trial, jitter_m) * rng.uniform(-1.0, 1.0, 2)
            if _clear_m(spec, frame, list(targets), at) >= wanted.clear_m:
                break
        else:
            raise StageError(STAGE, f"no room for a station near {place}", "change stations.count or clear_m")
        height = wanted.height_m + rng.uniform(-HEIGHT_SPREAD_M, HEIGHT_SPREAD_M)
        found.append(
            Pose(name=f"S{number:0{digits}}", rotation=_turn(spec, rng), centre=np.array([*at, height]))
        )
    return tuple(found)


def _off_stated_m(spec: ScanSpec, at: Array) -> float:
    """How far a stand is out of the way of the stations that are stated."""
    needed_m = spec.stations.clear_m + spec.targets.radius_mm / 1000.0
    return (
        min((float(np.linalg.norm(at - place)) for place in spec.stations.at_m), default=math.inf) - needed_m
    )


def _widened(trial: int, jitter_m: float) -> float:
    """Where there is no room, look farther about."""
    return jitter_m * (1.0 + 0.05 * max(0, trial - 20))


def _grid(spec: ScanSpec, count: tuple[int, int]) -> list[Array]:
    """Middles of equal cells of the floor under the frame, walked across and back and slowly along x."""
    cells = [(i, j if i % 2 == 0 else count[1] - 1 - j) for i in range(count[0]) for j in range(count[1])]
    return [(np.array(cell) + 0.5) / np.array(count) * plan_m(spec.structure) for cell in cells]


def _turn(spec: ScanSpec, rng: np.random.Generator) -> Array:
    """Any heading, and a tilt that the compensator has left: Rz(heading) Ry(b) Rx(a)."""
    heading = rng.uniform(0.0, 2.0 * math.pi)
    a, b = np.radians(spec.stations.level_sigma_arcsec / 3600.0) * rng.standard_normal(2)
    about_z = _rotation(2, heading)
    return about_z @ _rotation(1, b) @ _rotation(0, a)


def _rotation(axis: int, angle: float) -> Array:
    """Right-handed about x, y or z (0, 1, 2)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = math.cos(angle)
    turn[j, i], turn[i, j] = math.sin(angle), -math.sin(angle)
    return turn


def _clear_m(spec: ScanSpec, frame: Frame, targets: list[Target], at: Array) -> float:
    """Distance of a place on the floor to the nearest column, target or box."""
    gaps = [float(np.linalg.norm((c.foot + c.head)[:2] / 2.0 - at)) - c.radius_m - 0.1 for c in frame.columns]
    gaps += [float(np.linalg.norm(t.centre[:2] - at)) - spec.targets.radius_mm / 1000.0 for t in targets]
    for box in spec.room.box:
        turn = _rotation(2, math.radians(box.turn_deg))[:2, :2]
        beyond = np.abs((at - np.array(box.at_m)) @ turn) - np.array(box.size_m[:2]) / 2.0
        gaps.append(float(np.linalg.norm(np.maximum(beyond, 0.0))) if np.any(beyond > 0) else -1.0)
    return min(gaps, default=math.inf)
