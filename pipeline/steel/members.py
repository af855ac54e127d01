"""Members: the rods, columns and ball nodes in the registered cloud.

Takes the tiles and, where known, the nominal sizes; gives fitted members with covariance.  Works tile by tile
for the search and member by member for the fits, a few side by side, so that memory stays bounded.  What each
finds depends on nothing that runs beside it.  Leaves out nodes' centres and
eccentricity (nodes.py), inclination (columns.py) and deflection (deflection.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.vocabulary import Array
from pipeline.steel.assembly import balls_with_rods, joints_without_balls
from pipeline.steel.balls import find_ball
from pipeline.steel.common_radius import with_common_radius
from pipeline.steel.fitting import Fitted
from pipeline.steel.joining import all_pieces, join_pieces, longer_than
from pipeline.steel.meeting import meeting_places
from pipeline.steel.member_records import MemberOptions, Members, NominalSizes, Rod
from pipeline.steel.oriented import oriented
from pipeline.steel.rods import cut_at_balls, ends_at, measure_rod
from pipeline.steel.segments import Pieces, Window, find_pieces
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.tile_records import Tiles

STAGE = "members"
ROUGH = 1.8
"""A member's points may be this many times as far off it as usual."""
MOST_AT_ONCE = 2
"""Each tile that is searched holds some million points and what is computed from them in memory."""
MARGIN_M = 0.2
"""Tiles are searched with the points of their neighbours up to here."""


def find_members(tiles: Tiles, nominal: NominalSizes, options: MemberOptions, emit: Emit) -> Members:
    """Find and fit all members.

    Args:
        tiles: the registered points.
        nominal: diameters as drawn, which narrow the search; they are not needed and enter no result.
        options: noise and search.
        emit: progress.

    Raises:
        StageError: no cylinder is found.
    """
    reader = TileReader(tiles)
    pieces = _search(reader, nominal, options, part(emit, 0.0, 0.6))
    near = join_pieces(pieces, 0.15, np.zeros((0, 3)), 0.0)
    spheres = _balls(reader, longer_than(near, 0.3), nominal, options, part(emit, 0.6, 0.75))
    centres = np.array([b.place for b in spheres]).reshape(-1, 3)
    radii = np.array([b.radius_m for b in spheres])
    whole = join_pieces(near, options.gap_m, centres, 0.08)
    cut = cut_at_balls(whole, centres, radii)
    rods = _rods(reader, cut, (centres, radii), nominal, options, part(emit, 0.75, 1.0))
    if not rods:
        raise StageError(STAGE, _nothing(tiles, nominal, options), _remedy(nominal))
    usual = float(np.median([r.radius_m for r in rods]))
    columns = [r for r in rods if _is_column(r, centres, radii, nominal, options, usual)]
    grid = [r for r in rods if not any(r is c for c in columns)]
    named_columns, named_rods = _named(columns, "C"), _named(grid, "R")
    balls = balls_with_rods(with_common_radius(spheres, tiles.stations, options), named_rods, named_columns)
    return Members(
        stations=tiles.stations,
        range_bias_m=options.range_bias_mm / 1000,
        rods=named_rods,
        columns=named_columns,
        balls=balls,
        joints=joints_without_balls(named_rods, named_columns, balls),
    )


def _each[T](work: Sequence[Callable[[Callable[[], None]], T]], emit: Emit) -> list[T]:
    """Results of independent pieces of work, in order, a few side by side; each is given a tick to call."""
    finished: list[int] = []  # appending is atomic

    def job(number: int, told: Emit) -> T:
        def tick() -> None:
            told(Event(stage=STAGE, done=min(len(finished), len(work) - 1), total=len(work), message=""))

        tick()
        result = work[number](tick)
        finished.append(number)
        return result

    jobs = [partial(job, number) for number in range(len(work))]
    return side_by_side(jobs, emit, workers_for(min(len(work), MOST_AT_ONCE)))


def _search(reader: TileReader, nominal: NominalSizes, options: MemberOptions, emit: Emit) -> Pieces:
    """Pieces of cylinders of all tiles."""
    tiles, noise = reader.tiles, options.range_sigma_mm / 1000
    scanners = np.array([pose.translation for pose in tiles.stations])
    window = _window(nominal, options)

    def search(cell: Array, tick: Callable[[], None]) -> Pieces | None:
        low = cell * tiles.tile_m - MARGIN_M
        points = reader.box(low, low + tiles.tile_m + 2 * MARGIN_M)
        found = oriented(points, scanners, options.search_spacing_m, noise, tick)
        return None if found is None else find_pieces(found, window, options.reach_m, noise, tick)

    parts = _each([partial(search, cell) for cell in tiles.cells], emit)
    return all_pieces([part for part in parts if part is not None])


def _window(nominal: NominalSizes, options: MemberOptions) -> Window:
    """Radii of the cylinders that are looked for."""
    if not nominal.rods_mm and not nominal.columns_mm:
        return Window(ranges=((options.least_diameter_mm / 2000, options.largest_diameter_mm / 2000),))
    share = options.nominal_share
    given = [*nominal.rods_mm, *nominal.columns_mm]
    ranges = [(d / 2000 * (1 - share), d / 2000 * (1 + share)) for d in given]
    # sizes of one kind only: the other kind is still looked for
    if not nominal.columns_mm:
        ranges.append((1.3 * max(nominal.rods_mm) / 2000, options.largest_diameter_mm / 2000))
    if not nominal.rods_mm:
        ranges.append((options.least_diameter_mm / 2000, min(nominal.columns_mm) / 2000 / 1.3))
    return Window(ranges=tuple(ranges))


def _balls(
    reader: TileReader, pieces: Pieces, nominal: NominalSizes, options: MemberOptions, emit: Emit
) -> list[Fitted]:
    """Spheres at the places where rods meet; of two that are the same, the one with more points."""
    places = meeting_places(pieces)
    # neighbours after each other: their tiles are in memory then
    ordered = places[np.lexsort(np.floor(places / reader.tiles.tile_m).T)]

    def find(number: int, tick: Callable[[], None]) -> Fitted | None:
        return find_ball(ordered[number], reader, pieces, nominal, options, number)

    found = _each([partial(find, number) for number in range(len(ordered))], emit)
    kept: list[Fitted] = []
    for ball in sorted((b for b in found if b is not None), key=lambda b: -len(b.used)):
        if all(np.linalg.norm(ball.place - k.place) > 0.5 * (ball.radius_m + k.radius_m) for k in kept):
            kept.append(ball)
    return kept


def _rods(
    reader: TileReader,
    pieces: Pieces,
    balls: tuple[Array, Array],
    nominal: NominalSizes,
    options: MemberOptions,
    emit: Emit,
) -> list[Rod]:
    middles = 0.5 * (pieces.starts + pieces.ends)

    def measure(k: int, tick: Callable[[], None]) -> Rod | None:
        start, end, radius = pieces.starts[k], pieces.ends[k], float(pieces.radii_m[k])
        near = np.linalg.norm(balls[0] - middles[k], axis=1) < 0.5 * np.linalg.norm(end - start) + 1.0
        return measure_rod(start, end, radius, reader, (balls[0][near], balls[1][near]), options)

    order = np.lexsort(np.floor(middles / reader.tiles.tile_m).T).tolist()
    found = _each([partial(measure, k) for k in order], emit)
    window = _window(nominal, options)
    fitting = [rod for rod in found if rod is not None and window.holds(np.array([rod.radius_m]))[0]]
    return _without_rough(_without_doubles(fitting))


def _without_rough(rods: list[Rod]) -> list[Rod]:
    """The rods whose points lie on them as well as on most: edges of boxes fit a cylinder, but badly."""
    if not rods:
        return rods
    order = np.argsort([r.rms_m for r in rods])
    length = np.cumsum([rods[k].length_m for k in order])
    usual = rods[order[int(np.searchsorted(length, 0.5 * length[-1]))]].rms_m
    return [r for r in rods if r.rms_m < ROUGH * usual]


def _without_doubles(rods: list[Rod]) -> list[Rod]:
    """Of two fits to the same surface, the longer one."""
    ordered = sorted(rods, key=lambda r: -r.length_m)
    middles = np.array([0.5 * (r.start + r.end) for r in ordered]).reshape(-1, 3)
    axes = np.array([r.direction for r in ordered]).reshape(-1, 3)
    doubled = np.zeros(len(ordered), dtype=bool)
    for number, rod in enumerate(ordered):
        if doubled[number]:
            continue
        along = rod.along(middles)
        same = (rod.apart(middles) < 0.5 * rod.radius_m) & (np.abs(axes @ rod.direction) > 0.9)
        same &= (rod.first_m < along) & (along < rod.last_m)
        same[: number + 1] = False
        doubled |= same
    return [rod for rod, again in zip(ordered, doubled.tolist(), strict=True) if not again]


def _is_column(
    rod: Rod, centres: Array, radii: Array, nominal: NominalSizes, options: MemberOptions, usual_m: float
) -> bool:
    """Tell a column: upright, long, of a column's size where that is known, and not between two balls.

    Where it is not known, it is at least as thick as most members (``usual_m``, a radius): poles of targets
    stand upright as well.
    """
    upright = abs(rod.direction[2]) > np.cos(np.radians(options.column_tilt_deg))
    if not upright or rod.length_m < options.least_column_m:
        return False
    if nominal.columns_mm:
        near = [abs(2000 * rod.radius_m / d - 1) < options.nominal_share for d in nominal.columns_mm]
        return any(near)
    return rod.radius_m >= usual_m and int(ends_at(rod, centres, radii).sum()) < 2


def _named(rods: list[Rod], letter: str) -> tuple[Rod, ...]:
    """Names by place: from the lowest up, then by y and x."""
    ordered = sorted(rods, key=lambda r: tuple(np.round(0.5 * (r.start + r.end)[::-1], 1).tolist()))
    digits = max(len(str(len(rods))), 2)
    return tuple(replace(r, name=f"{letter}{k + 1:0{digits}d}") for k, r in enumerate(ordered))


def _nothing(tiles: Tiles, nominal: NominalSizes, options: MemberOptions) -> str:
    ranges = _window(nominal, options).ranges
    sizes = " or ".join(f"{2000 * low:.0f} to {2000 * high:.0f} mm" for low, high in ranges)
    return (
        f"no rod or column (a cylinder of diameter {sizes}, at least {options.least_length_m:g} m long) is "
        f"in the {int(tiles.counts.sum())} registered points"
    )


def _remedy(nominal: NominalSizes) -> str:
    if nominal.rods_mm or nominal.columns_mm:
        return "check structure.rod_diameters_mm and structure.column_diameters_mm, or leave them out"
    return "give structure.rod_diameters_mm and structure.column_diameters_mm, and check the clouds' unit"
