"""Balls of one size share it: what the others tell about the radius steadies a ball seen from one side.

From one side a sphere's centre and radius trade off along the line of sight.  The balls of a grid come in few
sizes; the mean radius of the others of its size, with their scatter, is an observation of a ball's radius.
The nominal size does not enter.

Source: the moment estimate of the scatter between balls, R. DerSimonian and N. Laird, "Meta-analysis in
clinical trials", Controlled Clinical Trials 7 (1986), 177-188; the update is a Kalman filter's.
"""

from dataclasses import replace

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.steel.fitting import Fitted
from pipeline.steel.member_records import MemberOptions, StationShare
from pipeline.steel.records import StationPose
from pipeline.steel.shares import with_stations

LEAST_OTHERS = 3
"""Fewer other balls say nothing about the scatter of the size."""
SHARED_M = 0.00006
"""What all balls of a size have wrong in common: paint, the beam's footprint; their mean is no better."""
SAME_SHARE = 0.06
"""Radii that differ by less than this share are of one size, if their sigmas allow it."""


def with_common_radius(
    balls: list[Fitted], stations: tuple[StationPose, ...], options: MemberOptions
) -> list[Fitted]:
    """The balls, each with its radius steadied by the others of its size."""
    radii = np.array([b.radius_m for b in balls])
    variances = np.array([b.covariance[3, 3] for b in balls])
    steadied = []
    for number, ball in enumerate(balls):
        same = np.abs(radii - radii[number]) < SAME_SHARE * radii[number] + 2 * np.sqrt(variances[number])
        same[number] = False
        if same.sum() < LEAST_OTHERS:
            steadied.append(ball)
            continue
        mean, variance = _mean_and_scatter(radii[same], variances[same])
        steadied.append(_observed(ball, mean, variance, stations, options))
    return steadied


def _mean_and_scatter(values: Array, variances: Array) -> tuple[float, float]:
    """Weighted mean, and variance of one further value about it (scatter and the mean's own)."""
    weight = 1 / variances
    mean = float(np.average(values, weights=weight))
    excess = float(weight @ (values - mean) ** 2) - (len(values) - 1)
    scatter = max(excess / float(weight.sum() - (weight**2).sum() / weight.sum()), 0.0)
    weight = 1 / (variances + scatter)
    return float(np.average(values, weights=weight)), scatter + 1 / float(weight.sum()) + SHARED_M**2


def _observed(
    ball: Fitted, radius: float, variance: float, stations: tuple[StationPose, ...], options: MemberOptions
) -> Fitted:
    """The ball after its radius has been observed as well."""
    gain = ball.covariance[:, 3] / (ball.covariance[3, 3] + variance)
    keep = np.eye(4) - np.outer(gain, [0, 0, 0, 1])
    noise = keep @ ball.noise_covariance @ keep.T + variance * np.outer(gain, gain)
    share = StationShare(stations=ball.share.stations, gains=keep @ ball.share.gains)
    step = gain * (radius - ball.radius_m)
    return replace(
        ball,
        place=ball.place + step[:3],
        radius_m=float(ball.radius_m + step[3]),
        noise_covariance=noise,
        share=share,
        covariance=with_stations(noise, share, stations, options.range_bias_mm / 1000),
    )
