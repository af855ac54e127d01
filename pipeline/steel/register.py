"""Stage *register*: all stations in one frame by one adjustment (paper, section 2.1).

Takes the survey and every station's named features; gives poses and features with their covariances, and the
gross errors by name.  Leaves out finding features (``targets.py``) and naming them (``naming.py``).
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.core.events import Emit, Event, part
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array
from pipeline.steel.adjustment import Adjusted, adjust
from pipeline.steel.approximate import Start, place_stations
from pipeline.steel.gross import name_gross_errors, offset_in_station, regrouped
from pipeline.steel.network import Network, build_network
from pipeline.steel.records import Feature, FeatureKind, Plumb, StationFeatures, StationPose
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import Registration, Residual, VarianceComponent
from pipeline.steel.state import Component, Group, groups_of
from pipeline.steel.station_checks import check_stations
from pipeline.steel.survey_records import RADIANS_PER_ARCSEC, SteelSurvey


def register(
    survey: SteelSurvey, found: Sequence[StationFeatures], options: RegisterOptions, emit: Emit
) -> Registration:
    """Register all stations of a survey on the features they share.

    The site frame is that of the control targets, where the survey has any, else the base station's.

    Args:
        survey: stations, scanner and control targets.
        found: the features of each station; those without a name are not used.
        options: see there.
        emit: progress.

    Raises:
        StageError: a station cannot be placed (too few common targets or none, collinear ones, a network in
            two parts), is mirrored or in another unit; the sentence names it.
    """
    network = build_network(survey, found)
    check_stations(network, survey.scanner.levelled)
    start = place_stations(network, survey.scanner.levelled, options, _tell(part(emit, 0.0, 0.3)))
    groups = groups_of(network, survey.scanner, shared_features(network))
    weights = tuple(starting_weights(group, start) for group in groups)
    adjusted = adjust(network, groups, weights, start.state, options, _tell(part(emit, 0.3, 1.0)))
    weights = regrouped(network, adjusted)
    if any(
        (new == 0).tolist() != (old == 0).tolist() for new, old in zip(weights, adjusted.weights, strict=True)
    ):
        adjusted = adjust(network, groups, weights, adjusted.state, options, _tell(part(emit, 0.99, 1.0)))
    emit(Event(stage="register", done=1, total=1))
    return _registration(network, start, adjusted, options)


def shared_features(network: Network) -> NDArray[np.bool_]:
    """(F,) whether a feature ties something: two stations see it, or it is a control target seen by one."""
    times = np.bincount(network.feature, minlength=len(network.names))
    for number in network.control:
        times[number] += 1
    return times > 1


def starting_weights(group: Group, start: Start) -> Array:
    """(n,) 1 where the initial values do not speak against an observation, else 0."""
    own = group.observation >= 0
    return np.where(own, start.agrees[np.where(own, group.observation, 0)], True).astype(float)


def _tell(emit: Emit) -> Callable[[int, int], None]:
    def tell(done: int, total: int) -> None:
        emit(Event(stage="register", done=min(done, total), total=total))

    return tell


def _registration(
    network: Network, start: Start, adjusted: Adjusted, options: RegisterOptions
) -> Registration:
    features = _features(network, adjusted)
    order = sorted(range(len(features)), key=lambda f: (network.names[f], network.kinds[f].value))
    seen_by = np.bincount(network.feature, minlength=len(network.names))
    return Registration(
        poses=poses_of(network, adjusted),
        features=tuple(features[f] for f in order),
        seen_by=tuple(int(seen_by[f]) for f in order),
        gross=name_gross_errors(network, adjusted, options),
        components=_components(adjusted),
        residuals=tuple(_residuals(network, adjusted)),
        order=tuple(network.stations[s] for s in start.order),
        parents=tuple("" if s < 0 else network.stations[s] for s in start.parents.tolist()),
        ring=tuple(int(r) for r in start.ring),
        rounds=adjusted.rounds,
        iterations=adjusted.iterations,
        largest_step_mm=adjusted.largest_step_m * 1000,
        plumb=_plumb(network, adjusted),
    )


def poses_of(network: Network, adjusted: Adjusted) -> tuple[StationPose, ...]:
    """The adjusted stations with their covariances."""
    count = len(network.stations)
    blocks = adjusted.covariances.stations.reshape(count, 6, count, 6)
    return tuple(
        StationPose(
            name=name,
            rotation=adjusted.state.rotations[s],
            translation=adjusted.state.translations[s],
            covariance=blocks[s, :, s, :].copy(),
            among=blocks[s].transpose(1, 0, 2).copy(),
        )
        for s, name in enumerate(network.stations)
    )


def _plumb(network: Network, adjusted: Adjusted) -> Plumb | None:
    """The adjusted plumb direction, the feature behind the last; None where nothing is levelled."""
    rows = [g for g, group in enumerate(adjusted.groups) if group.component is Component.PLUMB]
    if not rows:
        return None
    frame, found = adjusted.state.plumb, adjusted.covariances
    return Plumb(
        direction=frame[2],
        across=frame[:2],
        covariance=found.features[-1, :2, :2],
        stations=network.stations,
        with_stations=found.between[adjusted.places[rows[0]]][:, :, :2],
    )


def _features(network: Network, adjusted: Adjusted) -> list[Feature]:
    """All features in the site frame; one that a single station sees goes with its station."""
    shared = shared_features(network)
    state = adjusted.state
    size = {FeatureKind.POINT: 3, FeatureKind.LINE: 4, FeatureKind.PLANE: 3}
    features = []
    for f, (name, kind) in enumerate(zip(network.names, network.kinds, strict=True)):
        seen = [network.seen[n] for n in np.flatnonzero(network.feature == f)]
        if not shared[f]:
            features.append(_carried(network, adjusted, f))
            continue
        features.append(
            Feature(
                kind=kind,
                name=name,
                place=state.places[f],
                direction=np.zeros(3) if kind is FeatureKind.POINT else state.frames[f, 2],
                frame=state.frames[f],
                covariance=adjusted.covariances.features[f][: size[kind], : size[kind]],
                radius_m=float(np.mean([one.radius_m for one in seen])),
                points=sum(one.points for one in seen),
                rms_m=float(np.sqrt(np.mean([one.rms_m**2 for one in seen]))),
            )
        )
    return features


def _carried(network: Network, adjusted: Adjusted, feature: int) -> Feature:
    """A feature of one station in the site frame: its own covariance and, of a point, its station's."""
    number = int(np.flatnonzero(network.feature == feature)[0])
    station, seen = int(network.station[number]), network.seen[number]
    R, t = adjusted.state.rotations[station], adjusted.state.translations[station]
    covariance = adjusted.components[Component(seen.kind.value)] * seen.covariance
    frame = seen.frame if seen.kind is FeatureKind.POINT else seen.frame @ R.T
    if seen.kind is FeatureKind.POINT:
        count = len(network.stations)
        pose = adjusted.covariances.stations.reshape(count, 6, count, 6)[station, :, station, :]
        lever = np.concatenate([-cross_matrix(R @ seen.place), np.eye(3)], axis=1)
        covariance = R @ covariance @ R.T + lever @ pose @ lever.T
    return Feature(
        kind=seen.kind,
        name=seen.name,
        place=R @ seen.place + t,
        direction=R @ seen.direction,
        frame=frame,
        covariance=covariance,
        radius_m=seen.radius_m,
        points=seen.points,
        rms_m=seen.rms_m,
    )


def _components(adjusted: Adjusted) -> tuple[VarianceComponent, ...]:
    return tuple(
        VarianceComponent(
            kind=group.component.value,
            factor=float(np.sqrt(adjusted.components[group.component])),
            observations=len(group.station),
            redundancy=float(test.redundancy[weights > 0].sum()),
        )
        for group, test, weights in zip(adjusted.groups, adjusted.tests, adjusted.weights, strict=True)
    )


def _residuals(network: Network, adjusted: Adjusted) -> list[Residual]:
    rows = []
    for group, test, weights in zip(adjusted.groups, adjusted.tests, adjusted.weights, strict=True):
        if group.component in (Component.PLUMB, Component.CONTROL):
            continue
        for n, number in enumerate(group.observation.tolist()):
            seen, station = network.seen[number], int(group.station[n])
            R = adjusted.state.rotations[station]
            offset = R @ offset_in_station(group.component, test.residuals[n], seen.frame) * 1e3
            turn = {Component.LINE: test.residuals[n][2:], Component.PLANE: test.residuals[n][1:]}
            rows.append(
                Residual(
                    station=network.stations[station],
                    target=network.names[int(group.feature[n])],
                    kind=group.component.value,
                    offset_mm=(float(offset[0]), float(offset[1]), float(offset[2])),
                    turn_arcsec=float(np.linalg.norm(turn.get(group.component, np.zeros(1))))
                    / RADIANS_PER_ARCSEC,
                    normalised=float(np.sqrt(test.ratio[n])),
                    redundancy=float(test.redundancy[n]) / test.predicted.shape[1],
                    weight=float(weights[n]),
                )
            )
    return rows
