"""One adjustment of all stations and features, re-weighted until the weights stand: equations (5) to (7).

Takes the network with initial values; gives the adjusted state, its covariances and a verdict on every
observation.  Leaves out naming the gross errors (``gross.py``) and initial values (``approximate.py``).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from pipeline.core.errors import StageError
from pipeline.core.rotations import vector_from_rotation
from pipeline.core.vocabulary import Array
from pipeline.steel.equations import Covariances, Normals, Rows, assemble, covariances, solve
from pipeline.steel.network import Network
from pipeline.steel.point_shape import reshaped, stated_alike
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.state import Component, Group, State, linearise
from pipeline.steel.variance import Tested, components, reweighted, tested

SMALL_STEP = 0.01
"""A step shorter than this part of the best observation's sigma ends the iteration: the paper's bound is one
sigma, but a hundredth costs only one step more."""
LEVER_M = 50.0
"""Rotations are judged by what they move at this distance."""
FREE_ROUNDS = 8
SAME_COMPONENT, SAME_PLACE = 0.02, 0.05
"""Re-weighting ends once components change by less, and places by less than this part of a sigma."""


@dataclass(frozen=True, kw_only=True)
class Adjusted:
    """The adjusted network.

    Attributes:
        state: the unknowns.
        groups: the observations, kind by kind.
        weights: (n,) of each group, 0 where an observation is left out as gross.
        tests: of each group.
        components: variance of unit weight of each kind.
        covariances: of the unknowns.
        places: of each group, (n,) where its observations stand in ``covariances.between``.
        held: (S,) stations that define the frame.
        rounds, iterations: of re-weighting, and steps in all.
        largest_step_m: of the last iteration.
    """

    state: State
    groups: tuple[Group, ...]
    weights: tuple[Array, ...]
    tests: tuple[Tested, ...]
    components: dict[Component, float]
    covariances: Covariances
    places: tuple[NDArray[np.int64], ...]
    held: NDArray[np.bool_]
    rounds: int
    iterations: int
    largest_step_m: float


def adjust(
    network: Network,
    groups: tuple[Group, ...],
    weights: tuple[Array, ...],
    state: State,
    options: RegisterOptions,
    tell: Callable[[int, int], None],
) -> Adjusted:
    """Adjust, test, re-weight and begin again until weights and variance components stand.

    Args:
        network, groups: the observations.
        weights: (n,) starting weights of each group; 0 where the initial values speak against one.
        state: initial values.
        options: see there.
        tell: called with (round, rounds).

    Raises:
        StageError: a station is not held, or the adjustment does not converge.
    """
    held = np.zeros(len(network.stations), dtype=bool)
    held[network.base] = not network.control
    adjusted = Adjusted(
        state=state,
        groups=groups,
        weights=weights,
        tests=(),
        components=dict.fromkeys(Component, 1.0),
        covariances=Covariances(stations=np.zeros(0), features=np.zeros(0), between=np.zeros(0)),
        places=(),
        held=held,
        rounds=0,
        iterations=0,
        largest_step_m=np.inf,
    )
    alike = [stated_alike(group) for group in groups]
    for number in range(1, options.rounds + 1):
        tell(number, options.rounds)
        before = adjusted
        adjusted = _round(network, replace(adjusted, rounds=number), options)
        new = tuple(_new_weights(adjusted, options))
        if number > FREE_ROUNDS:
            # observations on the bound would go to and fro for ever: from now on weights only fall
            new = tuple(np.minimum(old, now) for old, now in zip(adjusted.weights, new, strict=True))
        if number > 1 and _stands(before, adjusted, new):
            break
        adjusted = replace(adjusted, weights=new, groups=_reshaped(network, adjusted, alike, options))
    return _round(network, adjusted, options)


def _round(network: Network, adjusted: Adjusted, options: RegisterOptions) -> Adjusted:
    """Iterate to the minimum with the weights as they are; test; estimate the components."""
    adjusted, normals, rows = _converged(network, adjusted, options)
    found = covariances(normals, adjusted.held, network.stations)
    tests = tuple(
        tested(row, weight, found, places, adjusted.components[group.component] * group.cofactor)
        for row, weight, places, group in zip(
            rows, adjusted.weights, normals.places, adjusted.groups, strict=True
        )
    )
    new = components(adjusted.groups, tests, adjusted.components, options)
    tests = tuple(
        replace(test, ratio=test.ratio * adjusted.components[group.component] / new[group.component])
        for group, test in zip(adjusted.groups, tests, strict=True)
    )
    return replace(adjusted, tests=tests, covariances=found, places=normals.places, components=new)


def _reshaped(
    network: Network, adjusted: Adjusted, alike: list[NDArray[np.bool_]], options: RegisterOptions
) -> tuple[Group, ...]:
    """The observations, those whose sigma was stated without a direction shaped as their residuals are."""
    return tuple(
        reshaped(group, mine, test, adjusted.components[group.component], network, options)
        if mine.any()
        else group
        for group, mine, test in zip(adjusted.groups, alike, adjusted.tests, strict=True)
    )


def _converged(
    network: Network, adjusted: Adjusted, options: RegisterOptions
) -> tuple[Adjusted, Normals, tuple[Rows, ...]]:
    state, taken, longest = adjusted.state, 0, np.inf
    enough = SMALL_STEP * _best_sigma_m(adjusted)
    while longest >= enough and taken < options.iterations:
        taken += 1
        normals, _ = _normals(network, adjusted, state)
        station_steps, feature_steps = solve(normals, network.stations)
        state = state.moved(station_steps, feature_steps, network.kinds)
        longest = float(max(np.abs(station_steps * ([LEVER_M] * 3 + [1] * 3)).max(), 0))
    if longest >= enough:
        raise StageError(
            "register",
            f"the adjustment still moves by {longest * 1000:.3g} mm after {taken} steps",
            "check the names of the targets",
        )
    normals, rows = _normals(network, adjusted, state)
    done = replace(adjusted, state=state, iterations=adjusted.iterations + taken, largest_step_m=longest)
    return done, normals, rows


def _normals(network: Network, adjusted: Adjusted, state: State) -> tuple[Normals, tuple[Rows, ...]]:
    rows = tuple(
        Rows(
            station=group.station,
            feature=group.feature,
            linear=linearise(network, group, state),
            information=np.linalg.inv(group.cofactor)
            * (weight / adjusted.components[group.component])[:, None, None],
        )
        for group, weight in zip(adjusted.groups, adjusted.weights, strict=True)
    )
    return assemble(rows, len(network.stations), len(network.names) + 1, adjusted.held), rows


def _best_sigma_m(adjusted: Adjusted) -> float:
    """Smallest standard deviation of an observed place."""
    return min(
        float(np.sqrt(np.einsum("nii->ni", group.cofactor)[:, :1].min()))
        for group in adjusted.groups
        if group.component is not Component.PLUMB
    )


def _new_weights(adjusted: Adjusted, options: RegisterOptions) -> list[Array]:
    """Equation (7), and zero for what cannot be noise: the worst of a station and of a feature first."""
    count = sum(len(group.station) for group in adjusted.groups)
    candidates = []
    new = []
    for g, (group, test, weight) in enumerate(
        zip(adjusted.groups, adjusted.tests, adjusted.weights, strict=True)
    ):
        new.append(reweighted(test, options.weight_bound))
        gross = is_gross(test, count, options)
        for n in np.flatnonzero(gross):
            if weight[n] == 0:
                new[g][n] = 0.0
            elif group.component is not Component.PLUMB:
                candidates.append((-float(test.ratio[n]), int(group.station[n]), int(group.feature[n]), g, n))
    taken_stations: set[int] = set()
    taken_features: set[int] = set()
    for _, station, feature, g, n in sorted(candidates):
        if station not in taken_stations and feature not in taken_features:
            new[g][n] = 0.0
        taken_stations.add(station)
        taken_features.add(feature)
    return new


def is_gross(test: Tested, count: int, options: RegisterOptions) -> NDArray[np.bool_]:
    """(n,) whether an observation can be no noise, with the significance shared out among all ``count``."""
    bound = chi2.isf(options.gross_significance / count, np.maximum(test.checked, 1))
    return (test.checked > 0) & (test.ratio * test.checked > bound)


def _stands(before: Adjusted, after: Adjusted, new: tuple[Array, ...]) -> bool:
    """Whether another round would change nothing: no station moved, nothing was left out anew."""
    same_gross = all(((old == 0) == (now == 0)).all() for old, now in zip(after.weights, new, strict=True))
    same = all(
        abs(after.components[kind] / before.components[kind] - 1) < SAME_COMPONENT for kind in Component
    )
    turns = np.einsum("nij,nkj->nik", after.state.rotations, before.state.rotations)
    moves = np.concatenate(
        [vector_from_rotation(turns), after.state.translations - before.state.translations], axis=1
    )
    sigmas = np.sqrt(np.diag(after.covariances.stations)).reshape(moves.shape)
    return same_gross and same and bool((np.abs(moves) <= SAME_PLACE * sigmas + 1e-12).all())
