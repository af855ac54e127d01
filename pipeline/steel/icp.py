"""Pairwise ICP, for comparison: neighbouring stations by their clouds alone.

Takes the registration and the imported clouds; gives for each station the motion onto the one it was placed
from, as generalised ICP finds it (A. Segal, D. Haehnel, S. Thrun, "Generalized-ICP", RSS 2009; small_gicp),
and the poses chained from the base.  It begins at the adjusted motion, so what it is off is where it settles,
not how far it had to come.  Leaves out targets.
"""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from pipeline.core.events import Emit, Event
from pipeline.core.rotations import angle_between_deg
from pipeline.core.vocabulary import Array
from pipeline.steel.chained import chained_pose
from pipeline.steel.clouds import station_points
from pipeline.steel.records import StationPose
from pipeline.steel.registration_records import IcpPair, IcpRegistration, Registration

POINTS_READ = 600_000
"""Of each cloud, evenly over its file; thinned to one a voxel after that."""
CLOUDS_KEPT = 6
POINTS_JUDGED = 5000


@dataclass(frozen=True, kw_only=True)
class IcpOptions:
    """Options of the comparison with ICP.

    Attributes:
        voxel_m: one point is kept in each.
        reach_m: partners farther off are none.
        iterations: at most.
        neighbours: points from which a normal is estimated.
    """

    voxel_m: float = field(default=0.1, metadata={"above": 0.0})
    reach_m: float = field(default=0.25, metadata={"above": 0.0})
    iterations: int = field(default=40, metadata={"minimum": 1})
    neighbours: int = field(default=12, metadata={"minimum": 5})


def compare_icp(
    registration: Registration, clouds: Mapping[str, Path], options: IcpOptions, emit: Emit
) -> IcpRegistration:
    """Register every station with a cloud onto its neighbour by ICP.

    Args:
        registration: neighbours and starting values.
        clouds: the .npy file of each station that has one (``clouds.import_cloud``).
        options: see there.
        emit: progress.
    """
    thinned = _Thinned(clouds, options)
    placed = {registration.order[0]: registration.pose(registration.order[0])}
    pairs = []
    parents = {
        pose.name: parent for pose, parent in zip(registration.poses, registration.parents, strict=True)
    }
    for number, station in enumerate(registration.order[1:], start=1):
        emit(Event(stage="icp", done=number - 1, total=len(registration.order), block=station))
        parent = parents[station]
        if station not in clouds or parent not in clouds or parent not in placed:
            continue
        pair = _pair(registration.pose(parent), registration.pose(station), thinned, options)
        pairs.append(pair)
        placed[station] = chained_pose(
            station, placed[parent], pair.rotation, pair.translation, np.zeros((6, 6))
        )
    emit(Event(stage="icp", done=1, total=1))
    poses = tuple(placed[pose.name] for pose in registration.poses if pose.name in placed)
    return IcpRegistration(pairs=tuple(pairs), poses=poses)


class _Thinned:
    """Thinned clouds with normals, the last few kept."""

    def __init__(self, clouds: Mapping[str, Path], options: IcpOptions) -> None:
        self._clouds, self._options = clouds, options
        self._kept: OrderedDict[str, tuple[Any, Any]] = OrderedDict()

    def cloud(self, station: str) -> tuple[Any, Any]:
        import small_gicp

        if station not in self._kept:
            points = station_points(self._clouds[station])
            few = np.asarray(points[:: max(len(points) // POINTS_READ, 1)], dtype=float)
            options = self._options
            self._kept[station] = small_gicp.preprocess_points(few, options.voxel_m, options.neighbours, 1)
        self._kept.move_to_end(station)
        while len(self._kept) > CLOUDS_KEPT:
            self._kept.popitem(last=False)
        return self._kept[station]


def _pair(first: StationPose, second: StationPose, thinned: _Thinned, options: IcpOptions) -> IcpPair:
    import small_gicp

    target, tree = thinned.cloud(first.name)
    source, _ = thinned.cloud(second.name)
    start = np.eye(4)
    start[:3, :3] = first.rotation.T @ second.rotation
    start[:3, 3] = first.rotation.T @ (second.translation - first.translation)
    found = small_gicp.align(
        target,
        source,
        tree,
        init_T_target_source=start,
        max_correspondence_distance=options.reach_m,
        max_iterations=options.iterations,
        rotation_epsilon=1e-6,
        translation_epsilon=1e-5,
    )
    moved = np.asarray(found.T_target_source, dtype=float)
    return IcpPair(
        first=first.name,
        second=second.name,
        offset_mm=float(np.linalg.norm(moved[:3, 3] - start[:3, 3])) * 1e3,
        turn_arcsec=float(angle_between_deg(moved[:3, :3], start[:3, :3])) * 3600,
        rms_mm=_plane_rms(target, source.points()[:, :3], moved, options.reach_m) * 1e3,
        matched=float(found.num_inliers) / max(source.size(), 1),
        converged=bool(found.converged),
        rotation=moved[:3, :3],
        translation=moved[:3, 3],
    )


def _plane_rms(target: Any, source: Array, moved: Array, reach_m: float) -> float:  # noqa: ANN401 - no types
    """Root mean square distance of the moved points from the planes of their partners, metres."""
    few = source[:: max(len(source) // POINTS_JUDGED, 1)] @ moved[:3, :3].T + moved[:3, 3]
    points, normals = np.asarray(target.points())[:, :3], np.asarray(target.normals())[:, :3]
    found = cKDTree(points).query(few, distance_upper_bound=reach_m)
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    has = np.isfinite(distance)
    if not has.any():
        return float("nan")
    away = np.sum((few[has] - points[nearest[has]]) * normals[nearest[has]], axis=1)
    return float(np.sqrt(np.mean(away**2)))
