"""Bundle adjustment with observed orientations: Levenberg-Marquardt on the reduced normal equations.

Takes a :class:`~pipeline.core.rig.Rig`, image measurements and priors (the POS); gives the adjusted rig with
its covariance.  Gross errors are weighted down by a Cauchy loss (iteratively reweighted least squares;
Triggs et al., 2000, section 3).  The equations themselves are in :mod:`pipeline.core.normals`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from pipeline.core.normals import (
    Chunk,
    Normals,
    assemble,
    covariance,
    order_along_cable,
    point_equations,
    point_steps,
    solve,
    split_along_cable,
    with_point_equations,
)
from pipeline.core.rig import Linearisation, Observations, Rig, linearise
from pipeline.core.rotations import vector_from_rotation
from pipeline.core.smooth_surface import SurfacePrior
from pipeline.core.vocabulary import Array

FIRST_DAMPING = 1e-8  # weak modes (focal length against stand-off) do not move under more
INTERSECTION_STEPS = 5
STILL_M = 2e-6  # the next step of an intersection is some thirty times shorter
WORST_PX = 50.0  # what a point behind the camera costs, so that a step cannot win by hiding points there


@dataclass(frozen=True, kw_only=True)
class RigPriors:
    """Observed orientations: a reference state and standard deviations (0 holds a value, inf frees it).

    Attributes:
        reference: the observed rig; its points are not used.
        body_sigmas: (F, 6) rotation vector in radians, then centre in metres.
        mount_sigmas: (C, 6) the same for the mountings.
        lens_sigmas: (C, 4) focal length and principal point in pixels, bend q.
        readout_sigma_m: of the way travelled while a frame is read.
    """

    reference: Rig
    body_sigmas: Array
    mount_sigmas: Array
    lens_sigmas: Array
    readout_sigma_m: float = 0.0

    @property
    def sigmas(self) -> Array:
        """All standard deviations in the order of the unknowns."""
        cameras = (self.body_sigmas, self.mount_sigmas, self.lens_sigmas)
        return np.concatenate([*(s.ravel() for s in cameras), [self.readout_sigma_m]])

    def deviation(self, rig: Rig) -> Array:
        """How far ``rig`` stands from the reference, in the order of the unknowns."""

        def poses(rotations: Array, observed: Array, centres: Array, observed_centres: Array) -> Array:
            turn = vector_from_rotation(rotations @ observed.transpose(0, 2, 1))
            return np.concatenate([turn, centres - observed_centres], axis=1).ravel()

        seen = self.reference
        return np.concatenate(
            [
                poses(rig.body_rotations, seen.body_rotations, rig.body_centres, seen.body_centres),
                poses(rig.mount_rotations, seen.mount_rotations, rig.mount_centres, seen.mount_centres),
                (rig.lenses - seen.lenses).ravel(),
                [rig.readout_m - seen.readout_m],
            ]
        )


@dataclass(frozen=True, kw_only=True)
class BundleOptions:
    """How to adjust.

    Attributes:
        sigma_px: standard deviation of an image coordinate, against which the priors are weighed.
        loss_scale_px: residual at which the Cauchy loss halves a measurement's weight.
        iterations: at most so many steps.
        tolerance: stop when a step lowers the cost by less than this fraction.
    """

    sigma_px: float = 0.2
    loss_scale_px: float = 1.0
    iterations: int = 30
    tolerance: float = 1e-6


@dataclass(frozen=True, kw_only=True)
class BundleResult:
    """The adjusted state.

    Attributes:
        rig: adjusted orientations and points.
        residuals: (N, 2) pixels.
        weights: (N,) share of its weight that the loss left to each measurement, 0 to 1.
        equations: builds the normal equations at the solution; only who asks for them waits for them.
        iterations: steps taken.
        surface: the surface prior as adjusted; None without one.
    """

    rig: Rig
    residuals: Array
    weights: Array
    equations: Callable[[], Normals]
    iterations: int
    surface: SurfacePrior | None = None

    @cached_property
    def normals(self) -> Normals:
        """The image measurements' and the POS' normal equations at the solution."""
        return self.equations()

    @cached_property
    def covariance(self) -> Array:
        """(U, U) of the orientation unknowns (zero rows where held), for the stated ``sigma_px``."""
        unknowns = self.rig.unknowns
        return covariance(_with_surface(self.normals, self.rig, self.surface))[:unknowns, :unknowns]


@dataclass(frozen=True)
class _State:
    """Where the adjustment stands, and what it costs there."""

    rig: Rig
    surface: SurfacePrior | None
    seen: Linearisation
    cost: float


def adjust_bundle(
    rig: Rig,
    observations: Observations,
    priors: RigPriors,
    options: BundleOptions,
    tell: Callable[[int, int], None],
    surface: SurfacePrior | None = None,
) -> BundleResult:
    """Adjust the rig and its points to the measurements and the priors.

    Args:
        rig: starting values.
        observations: image measurements; points numbered along the cable keep memory small.
        priors: observed orientations.
        options: see there.
        tell: called with (iteration, iterations) before each step.
        surface: pseudo-observations of the points; its covariance is then in that of the orientations.
    """
    order = order_along_cable(observations)
    observations = observations.subset(order)
    chunks = split_along_cable(observations, len(rig.points))

    def at(rig: Rig, surface: SurfacePrior | None) -> _State:
        seen = linearise(rig, observations)
        return _State(rig, surface, seen, _cost(seen, rig, priors, options, surface))

    here, damping, taken = at(rig, surface), FIRST_DAMPING, 0
    for taken in range(1, options.iterations + 1):
        tell(taken, options.iterations)
        normals = _normals(here.seen, here.rig, priors, options, chunks)
        there, damping = _lower(here, _with_surface(normals, here.rig, here.surface), damping, at)
        if there is None:
            break
        gain = 1 - there.cost / here.cost
        here, damping = there, max(damping / 10, 1e-9)
        if gain < options.tolerance:
            break
    residuals = np.empty_like(here.seen.residuals)
    residuals[order] = here.seen.residuals
    return BundleResult(
        rig=here.rig,
        residuals=residuals,
        weights=_weights(residuals, options),
        equations=partial(_normals, here.seen, here.rig, priors, options, chunks),
        iterations=taken,
        surface=here.surface,
    )


def _lower(
    here: _State, normals: Normals, damping: float, at: Callable[[Rig, SurfacePrior | None], _State]
) -> tuple[_State | None, float]:
    """The first state of lower cost, if there is one, steps damped more and more; and the damping."""
    unknowns = here.rig.unknowns
    for _ in range(10):
        step, point_steps = solve(normals, damping)
        surface = here.surface.moved(step[unknowns:]) if here.surface else None
        there = at(here.rig.moved(step[:unknowns], point_steps), surface)
        if there.cost < here.cost:
            return there, damping
        damping *= 10
    return None, damping


def intersect_points(rig: Rig, observations: Observations, *, gross_errors: bool = True) -> tuple[Rig, Array]:
    """Intersect the rays of every point, orientations held.

    Args:
        rig: its points are near their places.
        observations: image measurements.
        gross_errors: weigh them down from the third step on, when the points are nearer to their places.

    Returns:
        The rig with its points moved, and the (N, 2) residuals in pixels.
    """
    for number in range(INTERSECTION_STEPS):
        state = linearise(rig, observations, by_orientation=False)
        weights = _weights(state.residuals, BundleOptions())
        weighing = gross_errors and number >= 2
        roots = np.sqrt(weights) if weighing else (weights > 0).astype(float)
        steps = point_steps(*point_equations(state, roots, len(rig.points)))
        rig = replace(rig, points=rig.points + steps)
        if np.abs(steps).max(initial=0.0) < STILL_M and weighing == gross_errors:
            break
    return rig, linearise(rig, observations, by_orientation=False).residuals


def _normals(
    state: Linearisation, rig: Rig, priors: RigPriors, options: BundleOptions, chunks: tuple[Chunk, ...]
) -> Normals:
    roots = np.sqrt(_weights(state.residuals, options)) / options.sigma_px
    return assemble(state, roots, priors.deviation(rig), priors.sigmas, chunks)


def _with_surface(normals: Normals, rig: Rig, surface: SurfacePrior | None) -> Normals:
    return with_point_equations(normals, surface.equations(rig.points)) if surface else normals


def _squared(residuals: Array) -> Array:
    """Squared length of each residual in px^2; what cannot be projected counts as far off."""
    return np.nan_to_num(np.sum(residuals**2, axis=1), nan=WORST_PX**2)


def _weights(residuals: Array, options: BundleOptions) -> Array:
    weights = 1.0 / (1.0 + _squared(residuals) / options.loss_scale_px**2)
    return np.where(np.isfinite(residuals).all(axis=1), weights, 0.0)


def _cost(
    state: Linearisation, rig: Rig, priors: RigPriors, options: BundleOptions, surface: SurfacePrior | None
) -> float:
    scale = (options.loss_scale_px / options.sigma_px) ** 2
    images = scale * np.log1p(_squared(state.residuals) / options.loss_scale_px**2).sum()
    deviation = priors.deviation(rig)
    observed = priors.sigmas > 0
    said = surface.cost(rig.points) if surface else 0.0
    return float(images + np.sum((deviation[observed] / priors.sigmas[observed]) ** 2) + said)
