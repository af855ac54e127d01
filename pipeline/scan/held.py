"""What is known of how a scan lies to the cable's model, in the cable's own terms, and what is not.

Takes a fusion; gives shift along, turn about, shift across, tilt and scale with their sigmas and what holds
them.  A round smooth cable shows neither its turn nor a shift along itself.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import Fusion

OPEN_MM = 20.0
"""A direction with a larger sigma is not determined."""
TIED = 0.95
"""Turn and shift along are tied to a screw from this correlation on."""
LEVER = 10.0
"""A tilt is judged by what it moves at so many radii."""


@dataclass(frozen=True, kw_only=True)
class HeldWay:
    """One way in which the scan could lie otherwise.

    Attributes:
        name: along, turn, across, tilt or scale.
        sigma: in ``unit``; the whole play where nothing holds it.
        unit: mm, deg or share.
        held_by: points, relief, brightness, pairs; "" where nothing does.
    """

    name: str
    sigma: float
    unit: str
    held_by: str

    @property
    def determined(self) -> bool:
        """Whether anything holds it."""
        return bool(self.held_by)


def held_ways(fusion: Fusion, radius_m: float, middle_m: float) -> tuple[HeldWay, ...]:
    """The five ways, about the place on the cable's axis at ``middle_m`` along it."""
    gain = _in_cable(fusion, middle_m)
    sigma = np.sqrt(np.maximum(np.diag(gain @ fusion.covariance @ gain.T), 0))
    # how far each of the seven directions moves each way, by its own sigma
    motions = np.array([d.motion * d.sigma_mm for d in fusion.directions if d.determined]).reshape(-1, 7)
    names = [d.held_by for d in fusion.directions if d.determined]
    moved = np.abs(motions @ gain.T)
    rows = (
        ("along", [4], 1000.0, "mm", 1.0),
        ("turn", [1], 180 / np.pi, "deg", radius_m),
        ("across", [3, 5], 1000.0, "mm", 1.0),
        ("tilt", [0, 2], 180 / np.pi, "deg", LEVER * radius_m),
        ("scale", [6], 1.0, "share", radius_m),
    )
    ways = []
    for name, index, factor, unit, lever_m in rows:
        size = float(np.linalg.norm(sigma[index]))
        by = names[int(np.argmax(np.linalg.norm(moved[:, index], axis=1)))] if names else ""
        held_by = by if 1000 * lever_m * size < OPEN_MM else ""
        ways.append(HeldWay(name=name, sigma=factor * size, unit=unit, held_by=held_by))
    return tuple(ways)


def screw_mm_per_degree(fusion: Fusion, middle_m: float) -> float | None:
    """How far the scan slides for each degree of turn that is left open; None where the two are not tied.

    Ribs that wind around the cable lead a screw: turned along them it fits as well as before.
    """
    gain = _in_cable(fusion, middle_m)[[1, 4]]
    pair = gain @ fusion.covariance @ gain.T
    spread = np.sqrt(np.diag(pair))
    if spread.min() <= 0 or abs(pair[0, 1]) < TIED * spread[0] * spread[1]:
        return None
    return float(1000 * pair[0, 1] / pair[0, 0] * np.pi / 180)


def _in_cable(fusion: Fusion, middle_m: float) -> Array:
    """(7, 7) rotation, translation and scale about a place on the axis, in the cable's directions.

    The fusion's own centre lies off the axis: turned about the axis by an angle that nobody knows, it moves.
    """
    turn = fusion.placement.rotation.T
    away = fusion.placement.apply(np.array([0.0, middle_m, 0.0])) - fusion.centre
    gain = np.zeros((7, 7))
    gain[:3, :3] = turn
    gain[3:6, :3], gain[3:6, 3:6], gain[3:6, 6] = -turn @ cross_matrix(away), turn, turn @ away
    gain[6, 6] = 1.0
    return gain
