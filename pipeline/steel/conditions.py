"""What a station should see of a feature, and how that changes: equations (5) and (6) for three kinds.

Each observation is compared in its own frame (``Feature.frame``), where the observed values are zero:
    point   3: the centre's offsets along x, y, z of the station
    line    4: offsets of the axis along u and v where it passes the observed place, slopes towards u and v
    plane   3: offset along the observed normal at the observed place, slopes of the normal towards u and v
    plumb   2: x and y of the plumb direction in the station frame, of a levelled scanner
Takes many observations at once; gives residuals (observed minus computed) and derivatives.

Perturbations: a station's rotation site_from_station on the left, R <- exp([w]x) R, its translation by
addition; a feature along its own site frame (rows u, v, direction): place + a_u u + a_v v (a plane: a n),
direction + s_u u + s_v v; a point by addition.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.core.rotations import cross_matrix, rotation_from_vector
from pipeline.core.vocabulary import Array

STEEPEST = 0.01
"""Cosine below which a direction counts as no steeper."""


@dataclass(frozen=True, kw_only=True)
class Linear:
    """Observation equations of n observations of k values.

    Attributes:
        residuals: (n, k) observed minus computed.
        by_station: (n, k, 6) derivative of the computed by the station.
        by_feature: (n, k, f) by the feature: f = 3 for points and planes, 4 for lines, 2 for the plumb.
    """

    residuals: Array
    by_station: Array
    by_feature: Array


def points(R: Array, t: Array, place: Array, observed: Array) -> Linear:
    """Points at (n, 3) in the site frame, observed at (n, 3); station rotations (n, 3, 3), translations."""
    turned = R.transpose(0, 2, 1)
    away = place - t
    computed = np.einsum("nij,nj->ni", turned, away)
    by_station = np.concatenate([turned @ cross_matrix(away), -turned], axis=2)
    return Linear(residuals=observed - computed, by_station=by_station, by_feature=turned)


def lines(R: Array, t: Array, place: Array, frame: Array, observed: Array, seen_frame: Array) -> Linear:
    """Lines through (n, 3) along row 3 of (n, 3, 3) frames; observed places and frames of the stations."""
    q, e, dq, de = _in_seen_frame(R, t, place, frame, observed, seen_frame)
    dq_feature, de_feature = _by_line(R, frame, seen_frame)
    slopes, d_slopes = _slopes(e, np.concatenate([de, de_feature], axis=2))
    dq_all = np.concatenate([dq, dq_feature], axis=2)
    offsets = q[:, :2] - q[:, 2:] * slopes
    d_offsets = dq_all[:, :2] - slopes[:, :, None] * dq_all[:, 2:] - q[:, 2:, None] * d_slopes
    derivative = np.concatenate([d_offsets, d_slopes], axis=1)
    return Linear(
        residuals=-np.concatenate([offsets, slopes], axis=1),
        by_station=derivative[:, :, :6],
        by_feature=derivative[:, :, 6:],
    )


def planes(R: Array, t: Array, place: Array, frame: Array, observed: Array, seen_frame: Array) -> Linear:
    """Planes through (n, 3) across row 3 of (n, 3, 3) frames; observed places and frames of the stations."""
    q, e, dq, de = _in_seen_frame(R, t, place, frame, observed, seen_frame)
    to_seen = seen_frame @ R.transpose(0, 2, 1)
    zeros = np.zeros((len(q), 3, 2))
    dq_all = np.concatenate([dq, to_seen @ frame[:, 2, :, None], zeros], axis=2)
    de_feature = np.concatenate([np.zeros((len(q), 3, 1)), to_seen @ frame[:, :2].transpose(0, 2, 1)], axis=2)
    slopes, d_slopes = _slopes(e, np.concatenate([de, de_feature], axis=2))
    offset = q[:, 2] + np.sum(slopes * q[:, :2], axis=1)
    d_offset = (
        dq_all[:, 2]
        + np.einsum("ni,nij->nj", q[:, :2], d_slopes)
        + np.einsum("ni,nij->nj", slopes, dq_all[:, :2])
    )
    derivative = np.concatenate([d_offset[:, None], d_slopes], axis=1)
    return Linear(
        residuals=-np.column_stack([offset, slopes]),
        by_station=derivative[:, :, :6],
        by_feature=derivative[:, :, 6:],
    )


def plumbs(R: Array, frame: Array) -> Linear:
    """The plumb direction, row 3 of (3, 3) ``frame``, as n levelled stations see it: along their z."""
    turned = R.transpose(0, 2, 1)
    computed = turned @ frame[2]
    by_rotation = turned @ cross_matrix(frame[2])
    by_station = np.concatenate([by_rotation, np.zeros_like(by_rotation)], axis=2)
    return Linear(
        residuals=-computed[:, :2],
        by_station=by_station[:, :2],
        by_feature=(turned @ frame[:2].T)[:, :2],
    )


def moved_frame(frame: Array, slopes: Array) -> Array:
    """Frames (n, 3, 3), rows u, v, direction, whose direction leans by (n, 2) slopes towards u and v."""
    turn = np.stack([-slopes[:, 1], slopes[:, 0], np.zeros(len(slopes))], axis=1)
    axis = np.einsum("nji,nj->ni", frame, turn)
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    # the slope is the tangent of the angle
    angle = np.arctan(length) / np.maximum(length, 1e-300)
    return frame @ rotation_from_vector(axis * angle).transpose(0, 2, 1)


def _in_seen_frame(
    R: Array, t: Array, place: Array, frame: Array, observed: Array, seen_frame: Array
) -> tuple[Array, Array, Array, Array]:
    """Place and direction (n, 3) in the frame of the observation, and their derivatives by the station."""
    to_seen = seen_frame @ R.transpose(0, 2, 1)
    away, direction = place - t, frame[:, 2]
    q = np.einsum("nij,nj->ni", to_seen, away) - np.einsum("nij,nj->ni", seen_frame, observed)
    e = np.einsum("nij,nj->ni", to_seen, direction)
    zeros = np.zeros((len(q), 3, 3))
    dq = np.concatenate([to_seen @ cross_matrix(away), -to_seen], axis=2)
    de = np.concatenate([to_seen @ cross_matrix(direction), zeros], axis=2)
    return q, e, dq, de


def _by_line(R: Array, frame: Array, seen_frame: Array) -> tuple[Array, Array]:
    """Derivatives of place and direction by a line's (offset u, v, slope u, v), (n, 3, 4) each."""
    across = seen_frame @ R.transpose(0, 2, 1) @ frame[:, :2].transpose(0, 2, 1)
    zeros = np.zeros_like(across)
    return np.concatenate([across, zeros], axis=2), np.concatenate([zeros, across], axis=2)


def _slopes(e: Array, de: Array) -> tuple[Array, Array]:
    """Slopes (n, 2) of directions e (n, 3) and their derivatives; a direction may be told either way."""
    # one that is square to what was seen was named wrongly: it has no weight, but must stay finite
    e = np.column_stack([e[:, :2], np.copysign(np.maximum(np.abs(e[:, 2]), STEEPEST), e[:, 2])])
    slopes = e[:, :2] / e[:, 2:]
    return slopes, (de[:, :2] - slopes[:, :, None] * de[:, 2:]) / e[:, 2:, None]
