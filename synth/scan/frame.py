"""The space frame as built: nodes, balls, rods, columns in the hall's frame, from the specification alone."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from synth.scan.spec import STAGE, ScanSpec, Structure

ECCENTRIC_SEED, TILT_SEED = 201, 202
EMBEDDED_M = 0.001


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node: ``rods`` (3,) is where the axes of its rods meet, ``ball`` (3,) the centre of its ball."""

    name: str
    rods: Array
    ball: Array
    sag_m: float


@dataclass(frozen=True, kw_only=True)
class Rod:
    """A rod between the surfaces of two balls; ``inside_m`` is how far its steel goes on into them."""

    name: str
    nodes: tuple[str, str]
    start: Array
    end: Array
    radius_m: float
    inside_m: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column: its axis from ``foot`` to ``head``, judged from ``bottom`` to ``top`` on it (all (3,))."""

    name: str
    foot: Array
    head: Array
    bottom: Array
    top: Array
    radius_m: float


@dataclass(frozen=True, kw_only=True)
class Frame:
    """The whole structure."""

    nodes: tuple[Node, ...]
    rods: tuple[Rod, ...]
    columns: tuple[Column, ...]
    ball_radius_m: float
    span_m: float


def build_frame(spec: ScanSpec) -> Frame:
    """Lay out the structure.

    Raises:
        StageError: a node or column is named that is not there, or the tilts cannot be drawn.
    """
    structure = spec.structure
    span_m = structure.span_m or min(structure.bays) * structure.module_m
    if not structure.built:
        ball_m = structure.ball_diameter_mm / 2000.0
        return Frame(nodes=(), rods=(), columns=(), ball_radius_m=ball_m, span_m=span_m)
    nodes = _nodes(spec)
    return Frame(
        nodes=tuple(nodes.values()),
        rods=_rods(structure, nodes),
        columns=_columns(spec, nodes),
        ball_radius_m=structure.ball_diameter_mm / 2000.0,
        span_m=span_m,
    )


def plan_m(structure: Structure) -> Array:
    """(2,) length of the bottom chord's grid along x and y."""
    return np.array(structure.bays, float) * structure.module_m


def _nodes(spec: ScanSpec) -> dict[str, Node]:
    structure = spec.structure
    nx, ny = structure.bays
    places = {f"B{i + 1}-{j + 1}": np.array([i, j, 0.0]) for i in range(nx + 1) for j in range(ny + 1)} | {
        f"T{i + 1}-{j + 1}": np.array([i + 0.5, j + 0.5, 1.0]) for i in range(nx) for j in range(ny)
    }
    offsets = _offsets(spec, list(places))
    scale = np.array([structure.module_m, structure.module_m, structure.depth_m])
    found = {}
    for name, place in places.items():
        sag_m = (
            structure.sag_mm / 1000.0 * math.sin(math.pi * place[0] / nx) * math.sin(math.pi * place[1] / ny)
        )
        sag_m = 0.0 if abs(sag_m) < 1e-12 else sag_m
        rods = place * scale + np.array([0.0, 0.0, structure.height_m - sag_m])
        found[name] = Node(name=name, rods=rods, ball=rods + offsets[name], sag_m=sag_m)
    return found


def _offsets(spec: ScanSpec, names: list[str]) -> dict[str, Array]:
    """Ball minus meeting point of every node, metres."""
    structure = spec.structure
    stated = {e.node: np.array(e.offset_mm) / 1000.0 for e in structure.eccentric}
    for name in stated:
        if name not in names:
            raise StageError(
                STAGE, f"structure.eccentric names {name}", f"use one of {names[0]} to {names[-1]}"
            )
    rng = np.random.default_rng([spec.seed, ECCENTRIC_SEED])
    free = [name for name in names if name not in stated]
    chosen = rng.choice(len(free), round(structure.eccentric_share * len(free)), replace=False)
    drawn = {}
    for index in sorted(chosen):
        direction = rng.standard_normal(3)
        drawn[free[index]] = structure.eccentric_mm / 1000.0 * direction / np.linalg.norm(direction)
    return {name: np.zeros(3) for name in names} | drawn | stated


def _rods(structure: Structure, nodes: dict[str, Node]) -> tuple[Rod, ...]:
    nx, ny = structure.bays
    chord_m, diagonal_m = structure.chord_diameter_mm / 2000.0, structure.diagonal_diameter_mm / 2000.0
    pairs: list[tuple[str, str, float]] = []
    for layer, (mx, my) in {"B": (nx + 1, ny + 1), "T": (nx, ny)}.items():
        for i in range(1, mx + 1):
            for j in range(1, my + 1):
                here = f"{layer}{i}-{j}"
                pairs += [(here, f"{layer}{i + 1}-{j}", chord_m)] if i < mx else []
                pairs += [(here, f"{layer}{i}-{j + 1}", chord_m)] if j < my else []
    for i in range(1, nx + 1):
        for j in range(1, ny + 1):
            feet = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
            pairs += [(f"B{p}-{q}", f"T{i}-{j}", diagonal_m) for p, q in feet]
    ball_m = structure.ball_diameter_mm / 2000.0
    return tuple(_rod(nodes[a], nodes[b], radius_m, ball_m) for a, b, radius_m in pairs)


def _rod(a: Node, b: Node, radius_m: float, ball_m: float) -> Rod:
    along = (b.rods - a.rods) / np.linalg.norm(b.rods - a.rods)
    start = a.rods + _exit_m(a, along, ball_m) * along
    end = b.rods - _exit_m(b, -along, ball_m) * along
    inside = []
    for node in (a, b):
        off_m = radius_m + float(np.linalg.norm(node.ball - node.rods))
        inside.append(ball_m - math.sqrt(ball_m**2 - off_m**2) + EMBEDDED_M)
    return Rod(
        name=f"{a.name}_{b.name}",
        nodes=(a.name, b.name),
        start=start,
        end=end,
        radius_m=radius_m,
        inside_m=(inside[0], inside[1]),
    )


def _exit_m(node: Node, along: Array, ball_m: float) -> float:
    """Distance from the axes' meeting point, along an axis, to the ball's surface."""
    off = node.ball - node.rods
    middle_m = float(along @ off)
    return middle_m + math.sqrt(middle_m**2 - float(off @ off) + ball_m**2)


def _columns(spec: ScanSpec, nodes: dict[str, Node]) -> tuple[Column, ...]:
    structure = spec.structure
    places = _column_places(structure)
    tilts = _tilts_m(spec, len(places))
    return tuple(
        _column(structure, place, nodes[f"B{place[0]}-{place[1]}"], tilt)
        for place, tilt in zip(places, tilts, strict=True)
    )


def _column(structure: Structure, place: tuple[int, int], node: Node, tilt_m: Array) -> Column:
    """The head stays under its node; the foot makes room for the tilt."""
    head_z = float(node.ball[2]) - structure.ball_diameter_mm / 2000.0
    bottom_z, top_z = structure.judged_margin_m, head_z - structure.judged_margin_m
    if top_z <= bottom_z:
        raise StageError(STAGE, "structure.judged_margin_m leaves nothing of the columns", "lower it")
    per_metre = np.array([*tilt_m / (top_z - bottom_z), 1.0])
    head = np.array([*node.rods[:2], head_z])
    foot, bottom, top = (head + (z - head_z) * per_metre for z in (0.0, bottom_z, top_z))
    name = f"{place[0]}-{_letters(place[1])}"
    radius_m = structure.column_diameter_mm / 2000.0
    return Column(name=name, foot=foot, head=head, bottom=bottom, top=top, radius_m=radius_m)


def _letters(number: int) -> str:
    """1 is A, 26 Z, 27 AA."""
    before, last = divmod(number - 1, 26)
    return (_letters(before) if before else "") + chr(ord("A") + last)


def _column_places(structure: Structure) -> list[tuple[int, int]]:
    nx, ny = structure.bays
    if structure.column_at:
        for i, j in structure.column_at:
            if not (1 <= i <= nx + 1 and 1 <= j <= ny + 1):
                raise StageError(
                    STAGE, f"structure.column_at names ({i}, {j})", f"give 1 to {nx + 1}, 1 to {ny + 1}"
                )
        return list(dict.fromkeys(structure.column_at))
    if structure.column_step == 0:
        return [(1, 1), (nx + 1, 1), (nx + 1, ny + 1), (1, ny + 1)]
    edge = [(i, 1) for i in range(1, nx + 1)] + [(nx + 1, j) for j in range(1, ny + 1)]
    edge += [(i, ny + 1) for i in range(nx + 1, 1, -1)] + [(1, j) for j in range(ny + 1, 1, -1)]
    return edge[:: structure.column_step]


def _tilts_m(spec: ScanSpec, count: int) -> Array:
    """(count, 2) deviation of top from bottom, east and north."""
    structure = spec.structure
    least, most = structure.tilt_mm
    rng = np.random.default_rng([spec.seed, TILT_SEED])
    if structure.tilt_over is None:
        size_mm = rng.uniform(least, most, count)
    else:
        below, above = (
            structure.tilt_limit_mm - structure.tilt_clear_mm,
            structure.tilt_limit_mm + structure.tilt_clear_mm,
        )
        if structure.tilt_over > count or not least <= below or not above <= most:
            raise StageError(
                STAGE,
                f"structure.tilt_over = {structure.tilt_over} cannot be drawn",
                "widen structure.tilt_mm",
            )
        over = rng.permutation(count) < structure.tilt_over
        size_mm = np.where(over, rng.uniform(above, most, count), rng.uniform(least, below, count))
    azimuth = rng.uniform(0.0, 2.0 * math.pi, count)
    return size_mm[:, None] / 1000.0 * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
