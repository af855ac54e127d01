"""Linear functions of many fits at once: their covariance, with what the fits have in common.

Takes each fit's own noise, its share in the stations' errors and how the function follows it; gives the
function's covariance, the stations' and the plumb line's errors counted once.  Leaves out the fits.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.steel.member_records import Members, StationShare
from pipeline.steel.records import Plumb
from pipeline.steel.shares import with_stations


@dataclass(frozen=True, kw_only=True)
class Part:
    """One fit's part in a linear function.

    Attributes:
        gain: (m, p) how the function follows the fit's parameters.
        noise: (p, p) covariance of these from points alone.
        share: how these follow their stations.
    """

    gain: Array
    noise: Array
    share: StationShare


def joint_covariance(
    parts: Iterable[Part], members: Members, by_plumb: Array | None = None, plumb: Plumb | None = None
) -> Array:
    """Covariance (m, m) of a sum of linear functions of fits and of the plumb line.

    Args:
        parts: the fits'; noise of different ones is taken as independent.
        members: whose stations the shares count.
        by_plumb: (m, 2) how the function follows the slopes of ``plumb``; None: it does not.
        plumb: the plumb line; None: taken as exact.
    """
    parts = list(parts)
    share = together([(part.share, part.gain) for part in parts])
    noise = sum((part.gain @ part.noise @ part.gain.T for part in parts), np.zeros(()))
    total = with_stations(noise, share, members.stations, members.range_bias_m)
    if by_plumb is None or plumb is None:
        return total
    between = plumb.chosen([members.stations[n].name for n in share.stations.tolist()])
    mixed = np.einsum("kip,kpq,jq->ij", share.gains[:, :, :6], between, by_plumb, optimize=True)
    return np.asarray(total + mixed + mixed.T + by_plumb @ plumb.covariance @ by_plumb.T)


def together(parts: list[tuple[StationShare, Array]]) -> StationShare:
    """Share (k, m, 7) in the stations' errors of a sum of linear functions (m, p) of fits; not of none."""
    total: dict[int, Array] = {}
    for share, gain in parts:
        for station, own in zip(share.stations.tolist(), share.gains, strict=True):
            total[station] = total.get(station, 0.0) + gain @ own
    numbers = sorted(total)
    size = len(parts[0][1])
    return StationShare(
        stations=np.array(numbers, dtype=np.int64),
        gains=np.array([total[n] for n in numbers]).reshape(-1, size, 7),
    )
