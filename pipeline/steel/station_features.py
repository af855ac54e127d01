"""Stage *targets* of one station: what ties it to others, from its tables and its cloud.

Takes a station of the survey and its imported cloud; gives its features: targets listed or found, axes and
planes found, names given by hand.  Holds the order; leaves out finding (``targets.py``) and tables
(``target_table.py``, ``name_table.py``).
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, part
from pipeline.steel.clouds import StationCloud, station_points
from pipeline.steel.csv_rows import table_error
from pipeline.steel.name_table import Naming, read_name_table, sought, with_names
from pipeline.steel.records import FeatureKind, StationFeatures
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.survey_records import ScanStation, SteelSurvey
from pipeline.steel.target_table import read_target_table
from pipeline.steel.targets import find_figures, find_targets


def station_features(
    station: ScanStation,
    cloud: StationCloud | None,
    survey: SteelSurvey,
    options: TargetOptions,
    scratch: Path,
    emit: Emit,
) -> StationFeatures:
    """The features of a station.

    Args:
        station: of the survey.
        cloud: imported; None where the station has none.
        survey: scanner, targets and nominal sizes.
        options: see there.
        scratch: an existing folder for passing files.
        emit: progress.

    Raises:
        StageError: a table cannot be used; there is neither cloud nor table.
    """
    rows = () if station.names is None else read_name_table(station.names)
    _refuse_listed(station, rows)
    search = sought(options, rows)
    if cloud is None or not (search.planes or search.axes):
        found = _targets(station, cloud, survey, options, emit)
    else:
        points = _targets(station, cloud, survey, options, part(emit, 0.0, 0.5))
        more = find_figures(cloud, survey, search, scratch, part(emit, 0.5, 1.0))
        found = replace(points, features=(*points.features, *more))
    return with_names(found, rows, options)


def _refuse_listed(station: ScanStation, rows: Sequence[Naming]) -> None:
    """Targets that are listed have names, and no others are looked for."""
    for row in rows:
        if station.targets is not None and row.kind is FeatureKind.POINT:
            raise table_error(
                f'{row.where} names the target "{row.name}", but {station.targets} lists the targets of '
                f"{station.name}",
                "leave the row out, or leave station.targets out so that spheres are found in the cloud",
            )


def _targets(
    station: ScanStation,
    cloud: StationCloud | None,
    survey: SteelSurvey,
    options: TargetOptions,
    emit: Emit,
) -> StationFeatures:
    if station.targets is not None:
        return read_target_table(station.targets, station.name, survey.scanner)
    if cloud is None:
        raise StageError(
            "targets",
            f"the station {station.name} has neither cloud nor targets",
            "give station.cloud or station.targets in the survey",
        )
    return find_targets(station_points(cloud.path), station.name, survey, options, emit)
