"""Diameters at the stations against truth, as in the paper's Table 2, and those of the bare sheath."""

import math

from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import DiameterErrors, StationError

SAME_PLACE_M = 1e-4
"""Stations of one name that lie farther apart than this are not the same station."""


def compare_diameters(report: Document, truth: Document) -> DiameterErrors:
    """Compare each station of the truth with the run's station of that name.

    Raises:
        StageError: a station is missing in the run, lies elsewhere, or has no diameter.
    """
    found = {station.text("name"): station for station in report.items("stations")}
    rows = tuple(_station(found, station, report) for station in truth.items("stations"))
    if not rows:
        raise truth.error("stations is empty")
    sizes = [abs(row.difference_mm) for row in rows]
    return DiameterErrors(
        stations=rows,
        mean_absolute_mm=sum(sizes) / len(sizes),
        largest_mm=max(sizes),
        base_mean_absolute_mm=sum(abs(row.base_difference_mm) for row in rows) / len(rows),
    )


def _station(found: dict[str, Document], true: Document, report: Document) -> StationError:
    name = true.text("name")
    if name not in found:
        raise report.error(f"station {name} of the truth is not among the run's stations")
    position_m, model_mm = found[name].number("position_m"), found[name].number("diameter_mm")
    if abs(position_m - true.number("position_m")) > SAME_PLACE_M:
        raise report.error(
            f"station {name} lies at {position_m:g} m, in the truth at {true.number('position_m'):g} m"
        )
    truth_mm, sigma_mm = true.number("diameter_mm"), found[name].number_or_nan("sigma_mm")
    difference_mm = model_mm - truth_mm
    base_mm, true_base_mm = (place.number_or_nan("base_diameter_mm") for place in (found[name], true))
    return StationError(
        name=name,
        position_m=position_m,
        model_mm=model_mm,
        truth_mm=truth_mm,
        difference_mm=difference_mm,
        relative_percent=100 * abs(difference_mm) / truth_mm,
        sigma_mm=sigma_mm,
        z=abs(difference_mm) / sigma_mm if sigma_mm > 0 else math.nan,
        base_model_mm=base_mm,
        base_truth_mm=true_base_mm,
        base_difference_mm=base_mm - true_base_mm,
        base_sigma_mm=found[name].number_or_nan("base_sigma_mm"),
    )
