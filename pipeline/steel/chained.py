"""The usual way, for comparison: station after station, each moved onto one that already stands.

Takes the survey, the features and the registration; gives every station's pose as chaining would have it, and
how far it lies off the adjustment against its position in the chain.  Gross errors that the adjustment found
are left out here as well: what remains is the growth of the noise.  Loops are not closed: chaining does not.
A station that no single one before it holds by targets is missing here: the adjustment needs none such.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.core.events import Emit, Event
from pipeline.core.rotations import angle_between_deg, cross_matrix, rotation_from_vector
from pipeline.core.vocabulary import Array
from pipeline.steel.network import Network, build_network
from pipeline.steel.records import StationFeatures, StationPose
from pipeline.steel.registration_records import ChainedRegistration, ChainLink, Registration
from pipeline.steel.rodrigues import is_wide, level_motion, rodrigues_motion
from pipeline.steel.survey_records import SteelSurvey

ITERATIONS = 4


def compare_chained(
    survey: SteelSurvey, found: Sequence[StationFeatures], registration: Registration, emit: Emit
) -> ChainedRegistration:
    """Chain the stations in the order of their initial values, outward from the base."""
    network = build_network(survey, found)
    # of targets only: an axis may carry the same name
    gross = {(r.station, r.target) for r in registration.residuals if r.kind == "point" and r.weight == 0}
    seen = [
        {f: n for f, n in network.points_of(s).items() if (name, network.names[f]) not in gross}
        for s, name in enumerate(network.stations)
    ]
    factor = {component.kind: component.factor**2 for component in registration.components}.get("point", 1.0)
    order = [network.stations.index(name) for name in registration.order]
    poses = {order[0]: registration.poses[order[0]]}
    position = {order[0]: 0}
    for station in order[1:]:
        emit(Event(stage="chained", done=len(poses), total=len(order)))
        parent = _parent(network, seen, list(poses), station, level=survey.scanner.levelled)
        if parent is None:
            continue
        common = sorted(seen[parent].keys() & seen[station].keys())
        motion = _pair_motion(network, [seen[station][f] for f in common], [seen[parent][f] for f in common])
        poses[station] = chained_pose(network.stations[station], poses[parent], *motion, factor)
        position[station] = position[parent] + 1
    links = tuple(_link(poses[s], registration.poses[s], position[s]) for s in order if s in poses)
    return ChainedRegistration(poses=tuple(poses[s] for s in sorted(poses)), links=links)


def chained_pose(
    name: str,
    parent: StationPose,
    rotation: Array,
    translation: Array,
    covariance: Array,
    factor: float = 1.0,
) -> StationPose:
    """A pose in the site frame from its parent's and the motion parent_from_station with covariance (6, 6).

    Perturbations as in ``conditions.py``, so w = w_parent + R w_pair, dt = dt_parent + w_parent x R t + R dt.
    """
    R = parent.rotation
    arm = R @ translation
    by_parent, by_pair = np.eye(6), np.zeros((6, 6))
    by_parent[3:, :3] = -cross_matrix(arm)
    by_pair[:3, :3] = by_pair[3:, 3:] = R
    return StationPose(
        name=name,
        rotation=R @ rotation,
        translation=arm + parent.translation,
        covariance=by_parent @ parent.covariance @ by_parent.T + factor * by_pair @ covariance @ by_pair.T,
    )


def _parent(
    network: Network, seen: list[dict[int, int]], placed: list[int], station: int, *, level: bool
) -> int | None:
    """The placed station that shares most targets, those that hold a motion first; None where none does."""

    def shared(other: int) -> tuple[bool, int, int]:
        common = sorted(seen[other].keys() & seen[station].keys())
        rows = [seen[station][f] for f in common]
        wide = len(rows) >= 3 and is_wide(network.places[rows], network.largest_sigma_m(rows))
        return wide, len(common), -other

    best = max(placed, key=shared)
    return best if shared(best)[0] or (level and shared(best)[1] >= 2) else None


def _pair_motion(network: Network, mine: list[int], theirs: list[int]) -> tuple[Array, Array, Array]:
    """Motion parent_from_station of two stations by their common points, weighted, with covariance (6, 6)."""
    source, target = network.places[mine], network.places[theirs]
    own = np.array([network.seen[n].covariance for n in mine])
    other = np.array([network.seen[n].covariance for n in theirs])
    free = len(mine) >= 3 and is_wide(source, network.largest_sigma_m(mine))
    R, t = (rodrigues_motion if free else level_motion)(source, target)
    unknowns = slice(None) if free else [2, 3, 4, 5]  # a level pair turns about z only
    covariance = np.zeros((6, 6))
    for _ in range(ITERATIONS):
        turned = source @ R.T
        weight = np.linalg.inv(other + R @ own @ R.T)
        jacobian = np.concatenate([-cross_matrix(turned), np.tile(np.eye(3), (len(turned), 1, 1))], axis=2)
        jacobian = jacobian[:, :, unknowns]
        normal = np.einsum("nki,nkl,nlj->ij", jacobian, weight, jacobian)
        right = np.einsum("nki,nkl,nl->i", jacobian, weight, target - turned - t)
        step = np.zeros(6)
        step[unknowns] = np.linalg.solve(normal, right)
        R, t = rotation_from_vector(step[:3]) @ R, t + step[3:]
        held = np.arange(6)[unknowns]
        covariance = np.zeros((6, 6))
        covariance[np.ix_(held, held)] = np.linalg.inv(normal)
    return R, t, covariance


def _link(chained: StationPose, adjusted: StationPose, position: int) -> ChainLink:
    return ChainLink(
        station=chained.name,
        position=position,
        offset_mm=float(np.linalg.norm(chained.translation - adjusted.translation)) * 1e3,
        turn_arcsec=float(angle_between_deg(chained.rotation, adjusted.rotation)) * 3600,
        chained_sigma_mm=float(np.sqrt(np.trace(chained.covariance[3:, 3:]))) * 1e3,
        adjusted_sigma_mm=float(np.sqrt(np.trace(adjusted.covariance[3:, 3:]))) * 1e3,
    )
