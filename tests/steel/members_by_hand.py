"""Rods, balls and columns as the fits would give them: truth plus errors drawn from their own covariance."""

import numpy as np

from pipeline.steel.member_records import Ball, Members, Rod, StationShare
from tests.steel.seen_surfaces import station, unit

NO_SHARE = StationShare(stations=np.zeros(0, dtype=np.int64), gains=np.zeros((0, 5, 7)))


def rod(name, start, end, rng=None, offset_sigma=0.00005, slope_sigma=0.00005, radius=0.03, share=NO_SHARE):
    """A rod or column from ``start`` to ``end``; without ``rng`` exact."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    axis, length = unit(end - start), float(np.linalg.norm(end - start))
    u = unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    frame = np.stack([u, np.cross(axis, u), axis])
    covariance = np.diag(np.square([offset_sigma] * 2 + [slope_sigma] * 2 + [offset_sigma]))
    off = np.zeros(5) if rng is None else rng.normal(0, np.sqrt(np.diag(covariance)))
    direction = unit(axis + off[2:4] @ frame[:2])
    return Rod(
        name=name,
        place=0.5 * (start + end) + off[:2] @ frame[:2],
        direction=direction,
        frame=frame,
        radius_m=radius + off[4],
        first_m=-length / 2,
        last_m=length / 2,
        noise_covariance=covariance,
        share=share,
        covariance=covariance,
        points=5000,
        rms_m=0.0014,
        arc_deg=150.0,
    )


def ball(name, centre, rods, rng=None, sigma=0.0001, radius=0.1, column="", share=None):
    """A ball at ``centre`` that holds the named rods."""
    covariance = np.diag([sigma**2] * 4)
    off = np.zeros(4) if rng is None else rng.normal(0, sigma, 4)
    none = StationShare(stations=np.zeros(0, dtype=np.int64), gains=np.zeros((0, 4, 7)))
    return Ball(
        name=name,
        centre=np.asarray(centre, dtype=float) + off[:3],
        radius_m=radius + off[3],
        noise_covariance=covariance,
        share=none if share is None else share,
        covariance=covariance,
        rods=tuple(rods),
        column=column,
        points=1000,
        rms_m=0.0014,
    )


def members(rods=(), columns=(), balls=(), stations=None, range_bias_m=0.0):
    """All together."""
    return Members(
        stations=stations or (station((0, 0, 0)),),
        range_bias_m=range_bias_m,
        rods=tuple(rods),
        columns=tuple(columns),
        balls=tuple(balls),
    )
