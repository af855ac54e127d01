"""A steel run against the truth: stations, targets, gross errors, nodes, columns, grid, members, photos.

Takes report.json and a truth.json of ``python -m synth scan`` as documents; gives a
:class:`~pipeline.evaluate.steel.records.SteelEvaluation`.  The site frame of the truth is the base station's
true frame, so coordinates compare as they stand; stations are compared after the best rigid fit as well.
Judges with formulas of its own.
"""

from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.columns import compare_columns
from pipeline.evaluate.steel.deflection import compare_deflection
from pipeline.evaluate.steel.fusion import compare_fusion
from pipeline.evaluate.steel.gross import compare_gross
from pipeline.evaluate.steel.members import compare_balls, compare_cylinders
from pipeline.evaluate.steel.nodes import compare_nodes
from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.evaluate.steel.stations import compare_stations
from pipeline.evaluate.steel.targets import compare_targets

KIND = "steel"


def is_steel(document: Document) -> bool:
    """Whether a report.json or truth.json is one of a steel structure."""
    return document.values.get("kind") == KIND


def evaluate_steel(report: Document, truth: Document) -> SteelEvaluation:
    """Compare everything that both know; parts that the run did not judge are None.

    Raises:
        StageError: a value is missing, or run and truth do not belong together.
    """
    if not is_steel(truth):
        raise truth.error('kind is not "steel", but the run is one of a steel structure')
    members = report.inside("members") if "members" in report else None
    fitted = members is not None and bool(members.values.get("rods") or members.values.get("balls"))
    return SteelEvaluation(
        name=report.text("name"),
        stations=compare_stations(report, truth),
        targets=compare_targets(report, truth),
        gross=compare_gross(report, truth),
        nodes=compare_nodes(report, truth) if _listed(report, "nodes") else None,
        columns=compare_columns(report, truth) if _listed(report, "columns") else None,
        deflection=compare_deflection(report, truth) if "deflection" in report else None,
        rods=compare_cylinders(members, "rods", truth, "rods") if fitted and members else None,
        balls=compare_balls(members, truth) if fitted and members else None,
        fusion=compare_fusion(report, truth) if "fusion" in report else None,
    )


def _listed(report: Document, key: str) -> bool:
    return bool(report.values.get(key))
