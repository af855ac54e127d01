"""The unknowns of the adjustment of all stations: poses, features and the plumb direction.

Takes a network and the state of its unknowns; gives the observation equations of each kind of observation.
Leaves out solving them (``equations.py``).
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pipeline.core.rotations import rotation_from_vector
from pipeline.core.vocabulary import Array
from pipeline.steel import conditions
from pipeline.steel.conditions import Linear
from pipeline.steel.network import Network
from pipeline.steel.records import FeatureKind
from pipeline.steel.survey_records import Scanner


class Component(StrEnum):
    """Kinds of observations, each with a variance component of its own."""

    POINT = "point"
    LINE = "line"
    PLANE = "plane"
    PLUMB = "plumb"
    CONTROL = "control"


UNKNOWNS = {
    Component.POINT: 3,
    Component.LINE: 4,
    Component.PLANE: 3,
    Component.PLUMB: 2,
    Component.CONTROL: 3,
}
"""Values that a feature of each kind has."""


@dataclass(frozen=True, kw_only=True)
class Group:
    """Observations of one kind.

    Attributes:
        component: their kind.
        station, feature: (n,) int64; the plumb is the feature behind the last of the network.
        observation: (n,) int64 number in the network, -1 for plumb and control.
        cofactor: (n, k, k) covariance as stated.
    """

    component: Component
    station: NDArray[np.int64]
    feature: NDArray[np.int64]
    observation: NDArray[np.int64]
    cofactor: Array


@dataclass(frozen=True, kw_only=True)
class State:
    """The unknowns.

    Attributes:
        rotations: (S, 3, 3) site_from_station; translations: (S, 3) metres.
        places: (F, 3) metres in the site frame; frames: (F, 3, 3) rows u, v, direction, identity for points.
        plumb: (3, 3) the same for the plumb direction, upwards.
    """

    rotations: Array
    translations: Array
    places: Array
    frames: Array
    plumb: Array

    def moved(self, station_steps: Array, feature_steps: Array, kinds: tuple[FeatureKind, ...]) -> "State":
        """The state after steps (S, 6) and (F + 1, 4), as perturbed in ``conditions.py``; the plumb last."""
        steps = feature_steps[:-1]
        is_point, is_line, is_plane = (
            np.array([kind is wanted for kind in kinds], dtype=float)[:, None]
            for wanted in (FeatureKind.POINT, FeatureKind.LINE, FeatureKind.PLANE)
        )
        u, v, normal = self.frames[:, 0], self.frames[:, 1], self.frames[:, 2]
        along_line = steps[:, :1] * u + steps[:, 1:2] * v
        shift = is_point * steps[:, :3] + is_line * along_line + is_plane * steps[:, :1] * normal
        lean = is_line * steps[:, 2:4] + is_plane * steps[:, 1:3]
        return replace(
            self,
            rotations=rotation_from_vector(station_steps[:, :3]) @ self.rotations,
            translations=self.translations + station_steps[:, 3:],
            places=self.places + shift,
            frames=conditions.moved_frame(self.frames, lean),
            plumb=conditions.moved_frame(self.plumb[None], feature_steps[-1:, :2])[0],
        )


def groups_of(network: Network, scanner: Scanner, shared: NDArray[np.bool_]) -> tuple[Group, ...]:
    """All observations that take part, kind by kind; ``shared`` (F,): features that more than one sees."""
    groups = []
    for kind in FeatureKind:
        rows = network.of_kind(kind)
        rows = rows[shared[network.feature[rows]]] if len(rows) else rows
        if len(rows):
            groups.append(
                Group(
                    component=Component(kind.value),
                    station=network.station[rows],
                    feature=network.feature[rows],
                    observation=rows,
                    cofactor=np.array([network.seen[n].covariance for n in rows]),
                )
            )
    if scanner.levelled:
        count = len(network.stations)
        groups.append(
            _pseudo(
                Component.PLUMB,
                np.arange(count),
                np.full(count, len(network.names)),
                np.full(count, scanner.level_sigma_rad),
            )
        )
    control = [number for number in network.control if shared[number]]
    if control:
        sigmas = np.array([network.control[number][1] for number in control])
        groups.append(
            _pseudo(Component.CONTROL, np.full(len(control), network.base), np.array(control), sigmas)
        )
    return tuple(groups)


def _pseudo(
    component: Component, station: NDArray[np.int64], feature: NDArray[np.int64], sigmas: Array
) -> Group:
    return Group(
        component=component,
        station=station,
        feature=feature,
        observation=np.full(len(station), -1),
        cofactor=sigmas[:, None, None] ** 2 * np.eye(UNKNOWNS[component]),
    )


def linearise(network: Network, group: Group, state: State) -> Linear:
    """Observation equations of a group at the state."""
    R, t = state.rotations[group.station], state.translations[group.station]
    if group.component is Component.PLUMB:
        return conditions.plumbs(R, state.plumb)
    if group.component is Component.CONTROL:
        return _control(network, group, state)
    seen = [network.seen[n] for n in group.observation]
    observed = np.array([feature.place for feature in seen])
    place = state.places[group.feature]
    if group.component is Component.POINT:
        return conditions.points(R, t, place, observed)
    seen_frame = np.array([feature.frame for feature in seen])
    equations = conditions.lines if group.component is Component.LINE else conditions.planes
    return equations(R, t, place, state.frames[group.feature], observed, seen_frame)


def _control(network: Network, group: Group, state: State) -> Linear:
    known = np.array([network.control[number][0] for number in group.feature.tolist()])
    count = len(known)
    return Linear(
        residuals=known - state.places[group.feature],
        by_station=np.zeros((count, 3, 6)),
        by_feature=np.tile(np.eye(3), (count, 1, 1)),
    )
