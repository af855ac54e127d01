"""How stations are registered: the choices of a user and their defaults."""

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class RegisterOptions:
    """Options of the stage *register*.

    Attributes:
        start_tolerance_m: how far a target may lie off its neighbours' at the initial values and still agree.
        weight_bound: F of equation (7): variance ratio from which an observation gets its own variance; the
            paper's 4.13 is the non-centrality of a test of 0.1 % significance and 80 % power.
        gross_significance: chance that a survey without gross errors has one named.
        moved_at_most_m: a target farther off than this was not moved but misnamed.
        prior_redundancy: how many observations the stated accuracy is worth beside the residuals.
        rounds: most rounds of re-weighting.
        iterations: most steps of one adjustment.
    """

    start_tolerance_m: float = field(default=0.15, metadata={"above": 0.0})
    weight_bound: float = field(default=4.13, metadata={"above": 1.0})
    gross_significance: float = field(default=0.001, metadata={"above": 0.0, "maximum": 0.5})
    moved_at_most_m: float = field(default=1.0, metadata={"above": 0.0})
    prior_redundancy: float = field(default=5.0, metadata={"minimum": 0.0})
    rounds: int = field(default=30, metadata={"minimum": 1})
    iterations: int = field(default=25, metadata={"minimum": 1})


@dataclass(frozen=True, kw_only=True)
class TargetOptions:
    """Options of the stage *targets*.

    Attributes:
        farthest_m: targets farther off are not used.
        least_points: on a sphere.
        match_tolerance_m: how far mutual distances of the same targets may differ between two stations.
        least_common: targets that two stations must share before they are named alike.
        planes: also look for floors and walls, and register on those that stations share.
        least_plane_m2: smaller planes are left.
        axes: also look for the axes of columns and rods; costs 5 to 15 s a station.
        least_axis_m: shorter ones are left.
        axes_within_m: of the scanner.
        figure_sigma_mm: no axis or plane is taken to be better known: errors of the range that all points
            share, paint.
        roundness_share: by how much of its radius a member is out of round, one standard deviation.
    """

    farthest_m: float = field(default=40.0, metadata={"above": 0.0})
    least_points: int = field(default=12, metadata={"minimum": 6})
    match_tolerance_m: float = field(default=0.012, metadata={"above": 0.0})
    least_common: int = field(default=3, metadata={"minimum": 3})
    planes: bool = True
    least_plane_m2: float = field(default=4.0, metadata={"minimum": 1.0})
    axes: bool = True
    least_axis_m: float = field(default=1.0, metadata={"minimum": 0.5})
    axes_within_m: float = field(default=15.0, metadata={"above": 1.0})
    figure_sigma_mm: float = field(default=0.2, metadata={"minimum": 0.0})
    roundness_share: float = field(default=0.001, metadata={"minimum": 0.0, "maximum": 0.1})
