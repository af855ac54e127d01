"""What all points of a station share: how a fit follows the errors of the stations it rests on.

Takes rays, where they meet the fitted figure and their weights; gives the fit's derivative by the stations'
errors, and the covariance with them.  Leaves out the points' own noise.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.member_records import StationShare
from pipeline.steel.rays import Meeting, Rays
from pipeline.steel.records import StationPose


def share_of(rays: Rays, meeting: Meeting, weight: Array, stations: tuple[StationPose, ...]) -> StationShare:
    """How the least-squares solution follows the errors of the stations."""
    jacobian = meeting.jacobian
    inverse = np.linalg.inv(jacobian.T @ (weight[:, None] * jacobian))
    numbers = np.unique(rays.stations)
    gains = []
    for number in numbers.tolist():
        mine = rays.stations == number
        lever = rays.ranges[mine, None] * rays.directions[mine]
        # a point moved by d lies d . n off the surface, as seen along its ray -d . n / cosine
        outward = -meeting.normals[mine] / meeting.cosines[mine, None]
        by_error = np.column_stack([np.cross(lever, outward), outward, np.ones(mine.sum())])
        gains.append(-inverse @ (jacobian[mine] * weight[mine, None]).T @ by_error)
    return StationShare(stations=numbers, gains=np.array(gains))


def with_stations(
    noise: Array, share: StationShare, stations: tuple[StationPose, ...], range_bias_m: float
) -> Array:
    """Covariance (p, p) of a fit, or of anything linear in fits, with the errors of its stations.

    The points of one station all carry its error of registration: a fit over k stations cannot average it
    below sigma / sqrt(k), however many points there are.
    """
    by_pose, by_range = share.gains[:, :, :6], share.gains[:, :, 6]
    among = _among(tuple(stations[n] for n in share.stations.tolist()), share.stations)
    poses = np.einsum("aik,abkl,bjl->ij", by_pose, among, by_pose, optimize=True)
    return np.asarray(noise + poses + range_bias_m**2 * by_range.T @ by_range)


def _among(chosen: tuple[StationPose, ...], numbers: NDArray[np.int64]) -> Array:
    """(k, k, 6, 6) covariances of the poses of some stations; without knowledge they are independent."""
    among = np.zeros((len(chosen), len(chosen), 6, 6))
    for row, pose in enumerate(chosen):
        if len(pose.among):
            among[row] = pose.among[numbers]
        among[row, row] = pose.covariance
    return among
