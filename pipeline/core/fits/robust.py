"""Robust least squares for the fits: Levenberg-Marquardt inside iteratively reweighted least squares.

Takes a residual function with its Jacobian, starting values, weights and perhaps a prior; gives the estimate,
its covariance and the robust weights.  Leaves out geometry.

Source: P. J. Huber and E. M. Ronchetti, "Robust Statistics", 2nd ed. 2009, chapter 7: the weights, and the
covariance of a robust estimate in its simple form s^2 mean(psi^2) / mean(psi')^2 (J^T J)^-1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array

Residuals = Callable[[Array], tuple[Array, Array]]
"""(p,) parameters to (m,) residuals and their (m, p) Jacobian."""

MAD_TO_SIGMA = 1.4826
"""Median absolute deviation times this is the standard deviation of a normal distribution."""


class Loss(StrEnum):
    """How a residual grows beyond the noise."""

    LEAST_SQUARES = "least-squares"
    HUBER = "huber"
    TUKEY = "tukey"


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """Choices common to all fits.

    Attributes:
        loss: TUKEY forgets gross errors altogether (up to about a third of the points), HUBER bounds their
            pull, LEAST_SQUARES is for data that are known to be clean.
        noise_sigma: standard deviation of a point of weight 1, in the points' unit; None: from the residuals.
        least_noise_sigma: the one from the residuals is never taken to be smaller than this.
        iterations: most reweighting steps.
    """

    loss: Loss = Loss.TUKEY
    noise_sigma: float | None = None
    least_noise_sigma: float = 0.0
    iterations: int = 60


@dataclass(frozen=True, kw_only=True)
class Prior:
    """Observed parameters: mean (p,) and standard deviations (p,), inf where nothing is known."""

    mean: Array
    sigmas: Array


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Outcome of :func:`solve`.

    Attributes:
        values: (p,) parameters.
        covariance: (p, p).
        residuals: (m,), unweighted.
        robust_weights: (m,), in [0, 1].
        noise_sigma: standard deviation of a residual of weight 1.
    """

    values: Array
    covariance: Array
    residuals: Array
    robust_weights: Array
    noise_sigma: float


SMALL_STEP = 3e-4
"""Steps shorter than this, in units of the estimate's own sigma, end the iteration."""
TUNING = {Loss.HUBER: 1.345, Loss.TUKEY: 4.685}
"""Tuning constants for 95 % efficiency on normal noise."""


def solve(
    name: str,
    residuals: Residuals,
    start: ArrayLike,
    *,
    weights: Array,
    options: FitOptions,
    prior: Prior | None = None,
    update: Callable[[Array, Array], Array] | None = None,
) -> Estimate:
    """Minimise the robust sum of weights * residuals^2 (and the prior).

    Args:
        name: what is fitted, for the error message.
        residuals: see :data:`Residuals`.
        start: (p,) starting values.
        weights: (m,) inverse variances relative to a point of weight 1; 0 leaves a point out.
        options: loss and noise.
        prior: observed parameters.
        update: how a step is applied, values and step to values; addition by default.

    Raises:
        StageError: too few points, or they do not determine the parameters.
    """
    values = np.asarray(start, dtype=float)
    used = int(np.count_nonzero(weights > 0))
    known = 0 if prior is None else int(np.count_nonzero(np.isfinite(prior.sigmas)))
    if used + known < len(values) or not np.isfinite(values).all():
        raise StageError("fit", f"{used} points do not determine a {name}", "give more points or a wider arc")
    root = np.sqrt(weights)
    # TUKEY needs a good start and a scale that outliers did not make: both come from HUBER
    stages = [Loss.HUBER, Loss.TUKEY] if options.loss is Loss.TUKEY else [options.loss]
    for loss in stages:
        values = _reweighted(name, residuals, values, root, loss, options, prior, update or np.add)
    return _estimate(name, residuals, values, root, stages[-1], options, prior)


def noise_of(standardised: Array, parameter_count: int) -> float:
    """Standard deviation of weighted residuals by their median absolute value, corrected for the fit."""
    kept = np.sort(np.abs(standardised))
    # the fit makes about p residuals vanish: leave them out of the median, as in Huber and Ronchetti
    rest = kept[min(parameter_count, max(len(kept) - 1, 0)) :]
    return max(MAD_TO_SIGMA * float(np.median(rest)), 1e-15) if len(rest) else 1e-15


def _psi_weights(standardised: Array, loss: Loss) -> Array:
    """Robust weights psi(r) / r of residuals in units of their standard deviation."""
    size = np.abs(standardised)
    match loss:
        case Loss.LEAST_SQUARES:
            return np.ones_like(size)
        case Loss.HUBER:
            return TUNING[loss] / np.maximum(size, TUNING[loss])
        case Loss.TUKEY:
            return np.clip(1 - (size / TUNING[loss]) ** 2, 0, None) ** 2


def _psi_slope(standardised: Array, loss: Loss) -> Array:
    """Derivative of psi, for the covariance."""
    size = np.abs(standardised)
    match loss:
        case Loss.LEAST_SQUARES:
            return np.ones_like(size)
        case Loss.HUBER:
            return (size <= TUNING[loss]).astype(float)
        case Loss.TUKEY:
            inside = np.clip(1 - (size / TUNING[loss]) ** 2, 0, None)
            return inside * (inside - 4 * (size / TUNING[loss]) ** 2)


def _free_count(values: Array, prior: Prior | None) -> int:
    """Parameters that no prior holds."""
    return len(values) if prior is None else int(np.count_nonzero(np.isinf(prior.sigmas)))


def _scale(weighted: Array, root: Array, options: FitOptions, parameter_count: int) -> float:
    if options.noise_sigma is not None:
        return options.noise_sigma
    return max(noise_of(weighted[root > 0], parameter_count), options.least_noise_sigma)


def _reweighted(
    name: str,
    residuals: Residuals,
    values: Array,
    root: Array,
    loss: Loss,
    options: FitOptions,
    prior: Prior | None,
    update: Callable[[Array, Array], Array],
) -> Array:
    """Iterate weights and damped Gauss-Newton steps until the step is a tiny part of its own sigma."""
    damping = 1e-6
    raw, jacobian = residuals(values)
    # the scale only ever shrinks: a scale that breathes with the weights may cycle for ever
    sigma = _scale(raw * root, root, options, _free_count(values, prior))
    for _ in range(options.iterations):
        sigma = min(sigma, _scale(raw * root, root, options, _free_count(values, prior)))
        robust = _psi_weights(raw * root / sigma, loss)
        row = np.sqrt(robust) * root / sigma
        normal, right = _with_prior((jacobian * row[:, None]), raw * row, values, prior)
        cost = _cost(raw * row, values, prior)
        for _ in range(12):
            step = _step(name, normal, right, damping)
            trial = update(values, step)
            trial_raw, trial_jacobian = residuals(trial)
            if np.isfinite(trial_raw).all() and _cost(trial_raw * row, trial, prior) <= cost * (1 + 1e-12):
                values, raw, jacobian, damping = trial, trial_raw, trial_jacobian, max(damping / 10, 1e-12)
                break
            damping = max(damping * 10, 1e-6)
        else:
            return values
        if step @ normal @ step < SMALL_STEP**2:
            return values
    return values


def _with_prior(jacobian: Array, raw: Array, values: Array, prior: Prior | None) -> tuple[Array, Array]:
    normal, right = jacobian.T @ jacobian, -jacobian.T @ raw
    if prior is not None:
        information = prior.sigmas**-2.0
        normal = normal + np.diag(information)
        right = right - information * np.where(information > 0, values - prior.mean, 0)
    return normal, right


def _cost(raw: Array, values: Array, prior: Prior | None) -> float:
    cost = float(raw @ raw)
    if prior is not None:
        known = np.isfinite(prior.sigmas)
        cost += float(np.sum(((values - prior.mean)[known] / prior.sigmas[known]) ** 2))
    return cost


def _step(name: str, normal: Array, right: Array, damping: float) -> Array:
    scale = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    equalised = normal * scale[:, None] * scale[None, :]
    try:
        return scale * np.linalg.solve(equalised + damping * np.eye(len(right)), right * scale)
    except np.linalg.LinAlgError as error:
        raise _undetermined(name) from error


def _estimate(
    name: str,
    residuals: Residuals,
    values: Array,
    root: Array,
    loss: Loss,
    options: FitOptions,
    prior: Prior | None,
) -> Estimate:
    raw, jacobian = residuals(values)
    sigma = _scale(raw * root, root, options, _free_count(values, prior))
    standardised = raw * root / sigma
    robust = _psi_weights(standardised, loss)
    used = root > 0
    count, slope = int(used.sum()), float(np.mean(_psi_slope(standardised, loss)[used]))
    weighted = jacobian * root[:, None] / sigma
    normal, _ = _with_prior(weighted, raw * 0, values, prior)
    # parameters that a prior holds take up no points: their effective number is the trace of the hat matrix
    taken = float(np.trace(_invert(name, normal) @ (weighted.T @ weighted)))
    spread = float(np.sum((robust * standardised)[used] ** 2)) / max(count - taken, 1)
    if options.noise_sigma is not None or sigma <= options.least_noise_sigma:
        spread = max(spread, slope**2)  # a stated noise is a floor, not a wish
    effective = sigma * np.sqrt(max(spread, 1e-30)) / max(slope, 0.05)
    weighted = jacobian * root[:, None] / effective
    normal, _ = _with_prior(weighted, raw * 0, values, prior)
    return Estimate(
        values=values,
        covariance=_invert(name, normal),
        residuals=raw,
        robust_weights=robust,
        noise_sigma=sigma,
    )


def _invert(name: str, normal: Array) -> Array:
    scale = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    equalised = normal * scale[:, None] * scale[None, :]
    if not np.isfinite(equalised).all() or np.linalg.cond(equalised) > 1e14:
        raise _undetermined(name)
    return np.linalg.inv(equalised) * scale[:, None] * scale[None, :]


def _undetermined(name: str) -> StageError:
    return StageError("fit", f"the points do not determine a {name}", "give points that are spread wider")
