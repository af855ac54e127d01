"""Errors of what was measured on the structure: nodes, columns, deflection, members; as in compared.py."""

from dataclasses import dataclass

from pipeline.evaluate.steel.compared import Compared


@dataclass(frozen=True, kw_only=True)
class NodeError:
    """One true node that was found.

    Attributes:
        name, found: as built and as the run calls it.
        true_mm, found_mm: amount of the eccentricity.
        error_mm: length of the difference of the two vectors.
        amount_error_mm: difference of the amounts.
        sigma_mm: claimed.
        significant, eccentric: what the run says, what is true.
        ball_mm: distance of the ball's centre from its true place.
    """

    name: str
    found: str
    true_mm: float
    found_mm: float
    error_mm: float
    amount_error_mm: float
    sigma_mm: float
    significant: bool
    eccentric: bool
    ball_mm: float


@dataclass(frozen=True, kw_only=True)
class NodeErrors(Compared):
    """All nodes.

    Attributes:
        entries: those found and judged.
        true: nodes that there are.
        eccentric: of them truly eccentric and judged.
        false: reported eccentric without being so; false_percent of those judged that are not.
        missed: truly eccentric, judged, and not reported.
        rms_mm, largest_mm: vector error of the truly eccentric.
        amount_rms_mm, amount_largest_mm: error of the amount of the truly eccentric.
        ball_rms_mm: of the balls' centres.
        sigma: of the amounts of the truly eccentric.
    """

    entries: tuple[NodeError, ...]
    true: int
    eccentric: int
    false: int
    false_percent: float
    missed: int
    amount_rms_mm: float
    amount_largest_mm: float
    ball_rms_mm: float


@dataclass(frozen=True, kw_only=True)
class ColumnError:
    """One column.

    Attributes:
        name: of the column.
        true_mm, found_mm, deviation_error_mm: its deviation.
        north_error_mm, east_error_mm: of both components.
        direction_error_deg: angle between found and true direction.
        sigma_mm: claimed, of the deviation.
        over, truly_over: verdicts.
    """

    name: str
    true_mm: float
    found_mm: float
    deviation_error_mm: float
    north_error_mm: float
    east_error_mm: float
    direction_error_deg: float
    sigma_mm: float
    over: bool
    truly_over: bool


@dataclass(frozen=True, kw_only=True)
class ColumnErrors(Compared):
    """All columns.

    Attributes:
        entries: those found.
        missing: names of true columns that the run does not judge.
        rms_mm, largest_mm: error of the deviation.
        component_rms_mm, component_largest_mm: error of north and east.
        right, wrong: verdicts.
        over, truly_over: columns flagged, and to be flagged.
        sigma: over both components.
    """

    entries: tuple[ColumnError, ...]
    missing: tuple[str, ...]
    component_rms_mm: float
    component_largest_mm: float
    right: int
    wrong: int
    over: int
    truly_over: int


@dataclass(frozen=True, kw_only=True)
class DeflectionErrors(Compared):
    """Deflection of the balls below the plane of the supports, which the truth is put to as well.

    Attributes:
        nodes: compared.
        rms_mm, largest_mm: of the differences.
        found_mm, true_mm: largest deflection.
        verdict_right: whether the run's verdict on the limit is the truth's.
        sigma: over the nodes that are no supports.
    """

    nodes: int
    found_mm: float
    true_mm: float
    verdict_right: bool


@dataclass(frozen=True, kw_only=True)
class MemberErrors:
    """Fitted members of one kind.

    Attributes:
        true, found: how many there are, and how many of them were found.
        doubled: further finds of one that was found already.
        false: finds where none is.
        place_rms_mm: of the axis, or the centre.
        radius_rms_mm, radius_bias_mm: of the radius.
    """

    true: int
    found: int
    doubled: int
    false: int
    place_rms_mm: float
    radius_rms_mm: float
    radius_bias_mm: float
