"""Scale and place of a model that knows neither: from the travel and the nominal attitudes.

Takes the model's poses and the constructed ones of the same frames; gives the similarity to the cable frame.
What a user without control points would do: the path between the first and the last registered frame is
known and gives the scale, the track gives the direction of the axis, the attitudes turn the model about it.
"""

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array, Poses
from pipeline.evaluate.stock.records import StockModel

TRACK_WEIGHT = 1e6
"""Weight of the track's direction against an attitude's three axes: it is held, they turn about it only."""


def points_in_cable(model: StockModel, nominal: Poses) -> Array:
    """The model's points (m, 3) in the cable frame, metres.

    Args:
        model: as COLMAP gave it.
        nominal: constructed poses of the registered frames, one each.

    Raises:
        StageError: fewer than two frames were registered, or they lie on one spot.
    """
    scale, rotation, translation = similarity_from_track(model.poses, nominal)
    return scale * model.points @ rotation.T + translation


def similarity_from_track(poses: Poses, nominal: Poses) -> tuple[float, Array, Array]:
    """Scale, rotation (3, 3) and translation (3,) that take model points to the cable frame.

    Two directions of vectors are aligned as in W. Kabsch, Acta Cryst. A32, 1976: the track from the first to
    the last frame (held), and the axes of all cameras.

    Raises:
        StageError: fewer than two poses, or first and last at the same spot.
    """
    track, true_track = (p.centres[-1] - p.centres[0] for p in (poses, nominal))
    length = float(np.linalg.norm(track))
    if len(poses) < 2 or length <= 0:
        raise StageError(
            "stock colmap", f"{len(poses)} registered frames give no scale", "take more or sharper frames"
        )
    true_length = float(np.linalg.norm(true_track))
    directions = np.einsum("kji,kjl->il", nominal.rotations, poses.rotations)
    directions += TRACK_WEIGHT * len(poses) * np.outer(true_track / true_length, track / length)
    left, _, right = np.linalg.svd(directions)
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation, scale = left @ turn @ right, true_length / length
    middle, true_middle = (0.5 * (p.centres[0] + p.centres[-1]) for p in (poses, nominal))
    return scale, rotation, true_middle - scale * rotation @ middle
