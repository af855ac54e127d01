"""The options of every steel stage, and what the survey itself says about them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.core.options import build, override
from pipeline.steel.columns import ColumnOptions
from pipeline.steel.deflection import DeflectionOptions
from pipeline.steel.fuse_records import FuseOptions
from pipeline.steel.icp import IcpOptions
from pipeline.steel.member_records import MemberOptions
from pipeline.steel.nodes import NodeOptions
from pipeline.steel.photo_model import PhotoModelOptions
from pipeline.steel.registration_options import RegisterOptions, TargetOptions
from pipeline.steel.survey_records import SteelSurvey
from pipeline.steel.tile_records import TileOptions


@dataclass(frozen=True, kw_only=True)
class SteelOptions:
    """The options of every stage; ``[options.STAGE]`` in survey.toml, ``--set STAGE.key=value``."""

    targets: TargetOptions = field(default_factory=TargetOptions)
    register: RegisterOptions = field(default_factory=RegisterOptions)
    icp: IcpOptions = field(default_factory=IcpOptions)
    tiles: TileOptions = field(default_factory=TileOptions)
    members: MemberOptions = field(default_factory=MemberOptions)
    nodes: NodeOptions = field(default_factory=NodeOptions)
    columns: ColumnOptions = field(default_factory=ColumnOptions)
    deflection: DeflectionOptions = field(default_factory=DeflectionOptions)
    photos: PhotoModelOptions = field(default_factory=PhotoModelOptions)
    fuse: FuseOptions = field(default_factory=FuseOptions)


def bind_steel_options(survey: SteelSurvey, assignments: tuple[str, ...] = ()) -> SteelOptions:
    """The effective options: defaults, what the survey tells of scanner and limits, ``[options]``, ``--set``.

    Raises:
        StageError: an unknown stage or key, or a value that does not fit.
    """
    stated = {
        "members": {
            "range_sigma_mm": survey.scanner.range_sigma_mm,
            "angle_sigma_arcsec": survey.scanner.angle_sigma_arcsec,
        },
        "columns": {
            "north_deg": survey.structure.north_deg,
            "limit_mm": survey.structure.column_limit_mm,
        },
        "deflection": {"limit": survey.structure.deflection_limit},
    }
    written = dict(survey.options)
    for stage, values in stated.items():
        table = written.get(stage, {})
        written[stage] = {**values, **table} if isinstance(table, Mapping) else table
    options = build(SteelOptions, written, key="options")
    for assignment in assignments:
        options = override(options, assignment)
    return options
