"""Stations against each other before any is placed: one unit of length, one handedness.

Takes the network; raises one sentence that names the station.  Mutual distances and shapes need no pose, so a
station in millimetres or with mirrored coordinates is told as what it is, and not as a bad target.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.network import Network

UNITS = {
    1000.0: "millimetres",
    100.0: "centimetres",
    1 / 0.3048: "feet",
    1 / 0.0254: "inches",
}
"""How many to a metre."""
UNIT_TOLERANCE = 0.01

_CLEAR = 25.0
"""A mirror image is told where it fits this many times better in squares, and the other way not at all."""
_NOISE_SIGMAS = 5.0


def check_stations(network: Network, level: bool) -> None:
    """Refuse stations in another unit than the others, or mirrored against them.

    Args:
        network: who sees what.
        level: the stations' z axes are plumb, so that shapes are told apart in plan and in height.

    Raises:
        StageError: names the station.
    """
    seen = [network.points_of(station) for station in range(len(network.stations))]
    pairs = [
        (first, second, *_common(network, seen[first], seen[second]))
        for first, second in combinations(range(len(seen)), 2)
        if len(seen[first].keys() & seen[second].keys()) >= 2
    ]
    _check_units(network, {(a, b): _unit_ratio(x, y) for a, b, x, y, _ in pairs})
    hand = _plan_hand if level else _hand
    _check_hands(network, {(a, b): hand(x, y, sigma) for a, b, x, y, sigma in pairs})


def _common(network: Network, first: dict[int, int], second: dict[int, int]) -> tuple[Array, Array, float]:
    """Places (n, 3) of the common points in both stations, and the largest sigma among them."""
    shared = sorted(first.keys() & second.keys())
    sides = [[side[f] for f in shared] for side in (first, second)]
    sigma = max(network.largest_sigma_m(side) for side in sides)
    places = network.places
    return places[sides[0]], places[sides[1]], sigma


def _unit_ratio(x: Array, y: Array) -> float | None:
    """Length of y over length of x where it is clearly that of two units; 1.0 where alike; None: unclear."""
    i, j = np.triu_indices(len(x), 1)
    before, after = (np.linalg.norm(p[i] - p[j], axis=1) for p in (x, y))
    if not (before > 0).all() or not (after > 0).all():
        return None
    ratios = after / before
    middle = float(np.median(ratios))
    if np.median(np.abs(ratios / middle - 1)) > UNIT_TOLERANCE:
        return None
    for a in (1.0, *UNITS):
        for b in (1.0, *UNITS):
            if abs(middle * a / b - 1) < UNIT_TOLERANCE:
                return b / a
    return None


def _check_units(network: Network, ratios: Mapping[tuple[int, int], float | None]) -> None:
    scale = _labels(len(network.stations), ratios, lambda label, ratio: round(label * ratio, 9))
    usual = _usual(scale)
    for station, found in enumerate(scale):
        if found is None or abs(found / usual - 1) < UNIT_TOLERANCE:
            continue
        factor = found / usual
        per_metre = min(UNITS, key=lambda unit: abs(np.log(factor / unit)))
        if abs(factor / per_metre - 1) < UNIT_TOLERANCE:
            said = f"looks as if written in {UNITS[per_metre]}"
        else:
            said = f"is {factor:.4g} times as large"
        raise StageError(
            "register",
            f"station {network.stations[station]} {said} beside the others: distances between common targets "
            f"are {factor:.4g} times theirs",
            "give all stations in metres",
        )


def _hand(x: Array, y: Array, sigma_m: float) -> int | None:
    """1 where y is x moved, -1 where it is x mirrored, None where the points do not tell."""
    if len(x) < 4:
        return None
    return _sign(x - x.mean(axis=0), y - y.mean(axis=0), sigma_m)


def _plan_hand(x: Array, y: Array, sigma_m: float) -> int | None:
    """The same in plan, and in height."""
    if len(x) < 3:
        return None
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    plan = _sign(x[:, :2], y[:, :2], sigma_m)
    upright = float(np.sum((x[:, 2] - y[:, 2]) ** 2))
    upside_down = float(np.sum((x[:, 2] + y[:, 2]) ** 2))
    height = _clearer(upright, upside_down, len(x), sigma_m)
    if plan is None or height is None:
        # a plan that does not tell does not stand in the way of heights that do
        return -1 if -1 in (plan, height) else plan
    return plan * height


def _sign(x: Array, y: Array, sigma_m: float) -> int | None:
    """Whether a rotation or a reflection takes centred x (n, d) to y."""
    left, singular, right = np.linalg.svd(y.T @ x)
    total = float(np.sum(x**2) + np.sum(y**2))
    better = max(total - 2 * float(singular.sum()), 0.0)
    worse = max(total - 2 * float(singular[:-1].sum() - singular[-1]), 0.0)
    proper = np.linalg.det(left) * np.linalg.det(right) > 0
    return _clearer(*((better, worse) if proper else (worse, better)), len(x), sigma_m)


def _clearer(moved: float, mirrored: float, count: int, sigma_m: float) -> int | None:
    noise = count * (_NOISE_SIGMAS * sigma_m) ** 2
    if max(moved, mirrored) < max(_CLEAR * min(moved, mirrored), 4 * noise) or min(moved, mirrored) > noise:
        return None
    return 1 if moved < mirrored else -1


def _check_hands(network: Network, hands: Mapping[tuple[int, int], int | None]) -> None:
    labels = _labels(len(network.stations), hands, lambda label, hand: label * hand)
    usual = _usual(labels)
    for station, label in enumerate(labels):
        if label is not None and label != usual:
            raise StageError(
                "register",
                f"station {network.stations[station]} is mirrored against the others, a left-handed system",
                "export it with x, y, z right-handed and z up",
            )


def _labels(
    count: int,
    between: Mapping[tuple[int, int], float | None],
    combine: Callable[[float, float], float],
) -> list[float | None]:
    """Carry 1 outward from the station with most clear neighbours; None where nothing is known."""
    neighbours: dict[int, list[tuple[int, float]]] = {}
    for (first, second), value in between.items():
        if value is not None:
            neighbours.setdefault(first, []).append((second, value))
            neighbours.setdefault(second, []).append((first, 1 / value))
    labels: list[float | None] = [None] * count
    while unlabelled := [s for s in neighbours if labels[s] is None]:
        if any(label is not None for label in labels):
            break  # another part of the network: nothing to compare it with
        start = max(unlabelled, key=lambda s: len(neighbours[s]))
        labels[start] = 1.0
        queue = [start]
        while queue:
            station = queue.pop(0)
            for other, value in neighbours[station]:
                if labels[other] is None:
                    labels[other] = combine(labels[station] or 1.0, value)
                    queue.append(other)
    return labels


def _usual(labels: Sequence[float | None]) -> float:
    """The most frequent label, the first of those equally frequent."""
    counted = Counter(label for label in labels if label is not None)
    return counted.most_common(1)[0][0] if counted else 1.0
