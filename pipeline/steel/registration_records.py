"""What registering gives: poses, features, verdicts on the observations, and the comparisons with other ways.

Frames as in :mod:`pipeline.steel.records`; everything is frozen and can be stored.
"""

from dataclasses import dataclass
from enum import StrEnum

from pipeline.core.vocabulary import Array
from pipeline.steel.records import Feature, Plumb, StationPose

Vector = tuple[float, float, float]


class GrossKind(StrEnum):
    """What is wrong with an observation."""

    MOVED = "moved"
    MISNAMED = "misnamed"


@dataclass(frozen=True, kw_only=True)
class GrossError:
    """An observation that cannot be noise and was left out.

    Attributes:
        station, target: who saw what.
        kind: moved while the survey went on, or misnamed.
        offset_mm: seen minus expected place, site frame.
        size_mm: its length.
        sigma_mm: standard deviation of that length.
        fits: misnamed: the target that stands at the seen place; "" where there is none.
        together: stations that see the target at the same displaced place, this one included.
        instead: the only other station that sees the target, where no third one tells which of both is wrong;
            else "".
    """

    station: str
    target: str
    kind: GrossKind
    offset_mm: Vector
    size_mm: float
    sigma_mm: float
    fits: str
    together: tuple[str, ...]
    instead: str


@dataclass(frozen=True, kw_only=True)
class Residual:
    """One observation after the adjustment.

    Attributes:
        station, target: who saw what.
        kind: point, line or plane.
        offset_mm: observed minus adjusted, site frame; of a line across it, of a plane along its normal.
        turn_arcsec: of a line or plane, observed against adjusted direction; 0 for a point.
        normalised: root of e' Cov(e)^-1 e over the number of values, about 1; 0 where nothing checks it.
        redundancy: part of the observation that others check, 0 to 1.
        weight: 1, less by equation (7), 0 for a gross error.
    """

    station: str
    target: str
    kind: str
    offset_mm: Vector
    turn_arcsec: float
    normalised: float
    redundancy: float
    weight: float


@dataclass(frozen=True, kw_only=True)
class VarianceComponent:
    """How well one kind of observation fits.

    Attributes:
        kind: point, line, plane or plumb.
        factor: standard deviation found over standard deviation stated.
        observations: of this kind.
        redundancy: number of values that others check.
    """

    kind: str
    factor: float
    observations: int
    redundancy: float


@dataclass(frozen=True, kw_only=True)
class Registration:
    """All stations in the site frame.

    Attributes:
        poses: one a station, in the survey's order.
        features: every named feature in the site frame, with its covariance; sorted by name.
        seen_by: how many stations each feature was taken from; 1 where nothing checks it.
        gross: observations that were left out.
        components: of each kind of observation.
        residuals: every observation of a feature that more than one station sees.
        order: stations as they were placed, the base first.
        parents: for each station of ``poses`` the station it was placed from, "" for the base.
        ring: for each station how many set-ups it is away from the base.
        rounds, iterations: of re-weighting, and adjustment steps in all.
        largest_step_mm: of the last step.
        plumb: the plumb line that levelled stations agree on; None: they are not levelled.
    """

    poses: tuple[StationPose, ...]
    features: tuple[Feature, ...]
    seen_by: tuple[int, ...]
    gross: tuple[GrossError, ...]
    components: tuple[VarianceComponent, ...]
    residuals: tuple[Residual, ...]
    order: tuple[str, ...]
    parents: tuple[str, ...]
    ring: tuple[int, ...]
    rounds: int
    iterations: int
    largest_step_mm: float
    plumb: Plumb | None = None

    def pose(self, station: str) -> StationPose:
        """The pose of a station by its name."""
        return next(pose for pose in self.poses if pose.name == station)


@dataclass(frozen=True, kw_only=True)
class ChainLink:
    """One station of the comparison.

    Attributes:
        station: its name.
        position: how many set-ups it is away from the base along the chain.
        offset_mm: place from chaining minus place from the adjustment, length.
        turn_arcsec: angle between the two attitudes.
        chained_sigma_mm, adjusted_sigma_mm: predicted standard deviation of the place, root of the trace.
    """

    station: str
    position: int
    offset_mm: float
    turn_arcsec: float
    chained_sigma_mm: float
    adjusted_sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class ChainedRegistration:
    """Registration station by station, for comparison.

    Attributes:
        poses: one a station, in the survey's order, of those that can be chained.
        links: one for each, in the order of the chain.
    """

    poses: tuple[StationPose, ...]
    links: tuple[ChainLink, ...]


@dataclass(frozen=True, kw_only=True)
class IcpPair:
    """Two neighbouring stations by their clouds alone.

    Attributes:
        first, second: their names; the second is moved onto the first.
        offset_mm: translation from ICP minus translation from the adjustment, length.
        turn_arcsec: angle between the two.
        rms_mm: of the distances between matched points and planes.
        matched: part of the points that found a partner.
        converged: whether ICP says so.
        rotation, translation: (3, 3), (3,) first_from_second, metres.
    """

    first: str
    second: str
    offset_mm: float
    turn_arcsec: float
    rms_mm: float
    matched: float
    converged: bool
    rotation: Array
    translation: Array


@dataclass(frozen=True, kw_only=True)
class IcpRegistration:
    """Pairwise ICP along the tree of the initial values, for comparison.

    Attributes:
        pairs: one a station but the base.
        poses: the pairs chained from the base; covariances zero, ICP gives none.
    """

    pairs: tuple[IcpPair, ...]
    poses: tuple[StationPose, ...]
