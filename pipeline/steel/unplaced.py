"""Why stations cannot be placed: each reason its own sentence.

Takes the network and the stations placed so far; gives the error to raise.  Only told once nothing else can
be placed, so that it never stands in the way of a network that holds together some other way.
"""

import numpy as np

from pipeline.core.errors import StageError
from pipeline.steel.network import Network
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.rodrigues import is_wide


def explain(
    network: Network, placed: list[int], seen: list[dict[int, int]], level: bool, options: RegisterOptions
) -> StageError:
    """The sentence about the station that shares most with those placed."""
    least = 2 if level else 3
    known = {f for s in placed for f in seen[s]}
    outside = [s for s in range(len(seen)) if s not in placed]
    alone = [
        s for s in outside if not any(seen[s].keys() & seen[o].keys() for o in range(len(seen)) if o != s)
    ]
    figures = _figures_of(network, placed, outside)
    if figures:
        return figures
    if alone:
        return _error(
            f"station {network.stations[alone[0]]} has no target in common with any other station",
            "name its targets as the others do, or scan it again with common targets",
        )
    best = max(outside, key=lambda s: (len(known & seen[s].keys()), -s))
    common = sorted(known & seen[best].keys())
    name = network.stations[best]
    if not common:
        others = ", ".join(network.stations[s] for s in outside[:5]) + (" ..." if len(outside) > 5 else "")
        return _error(
            f"the network falls apart: {len(outside)} of {len(seen)} stations ({others}) share no target "
            f"with the part around the base station {network.stations[network.base]}",
            "scan targets that tie the parts together",
        )
    targets = ", ".join(network.names[f] for f in common)
    if len(common) < least:
        return _error(
            f"station {name} shares only {len(common)} target{'s' if len(common) > 1 else ''} ({targets}) "
            f"with the stations placed before it",
            f"it needs at least {least}, or axes and planes named by hand (station.names) that hold it",
        )
    if _on_a_line(network, seen[best], common, level):
        return _error(
            f"the targets that station {name} shares with the others ({targets}) lie on one line",
            "give it a common target off that line",
        )
    return _error(
        f"the targets that station {name} shares with the others ({targets}) do not lie as they do there, "
        f"by more than {options.start_tolerance_m:g} m",
        "check their names and that none was moved",
    )


def _figures_of(network: Network, placed: list[int], outside: list[int]) -> StageError | None:
    """The sentence where a station shares named axes or planes, and they did not place it."""
    known = {int(network.feature[n]) for s in placed for n in network.figures_of(s)}
    for station in outside:
        shared = sorted({int(network.feature[n]) for n in network.figures_of(station)} & known)
        if shared:
            names, mine = ", ".join(network.names[f] for f in shared), network.stations[station]
            return _error(
                f"the axes and planes that station {mine} shares with those placed ({names}) do not hold it, "
                "or do not lie as they do there",
                "check their names, or name more by hand in station.names (three planes or axes that face "
                "different ways, or two columns and a floor), or add targets",
            )
    return None


def _on_a_line(network: Network, mine: dict[int, int], common: list[int], level: bool) -> bool:
    points = np.array([network.seen[mine[f]].place for f in common])
    sigma = network.largest_sigma_m([mine[f] for f in common])
    if level:
        return float(np.ptp(points[:, :2], axis=0).max()) < 5 * sigma
    return not is_wide(points, sigma)


def _error(cause: str, remedy: str) -> StageError:
    return StageError("register", cause, remedy)
