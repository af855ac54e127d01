"""The evaluation of a steel run as text for the screen, in aligned columns; what is not known is a dash."""

from pipeline.evaluate.steel.compared import SigmaCheck
from pipeline.evaluate.steel.records import FusionErrors, SteelEvaluation
from pipeline.evaluate.steel.registration_errors import GrossVerdict, StationErrors, TargetErrors
from pipeline.evaluate.steel.structure_errors import ColumnErrors, DeflectionErrors, MemberErrors, NodeErrors
from pipeline.evaluate.text import aligned, number

SHOWN = 30
"""Longer lists show their worst entries."""


def format_steel(found: SteelEvaluation) -> str:
    """Lay out everything that was compared."""
    parts = [_stations(found.name, found.stations), _targets(found.targets), _gross(found.gross)]
    if found.columns is not None:
        parts.append(_columns(found.columns))
    if found.nodes is not None:
        parts.append(_nodes(found.nodes))
    if found.deflection is not None:
        parts.append([_deflection(found.deflection)])
    parts.extend(
        [_members(kind, errors)]
        for kind, errors in (("Rods", found.rods), ("Balls", found.balls))
        if errors is not None
    )
    if found.fusion is not None:
        parts.append([_fusion(found.fusion)])
    return "\n\n".join("\n".join(lines) for lines in parts) + "\n"


def _stations(name: str, found: StationErrors) -> list[str]:
    rows = [
        [
            row.name,
            str(row.ring),
            *(number(value, 3, sign=True) for value in row.offset_mm),
            number(row.distance_mm, 3),
            number(row.attitude_arcsec, 2),
            number(row.fitted_mm, 3),
            number(row.chained_mm, 2),
            number(row.icp_mm, 2),
        ]
        for row in sorted(found.entries, key=lambda row: -row.distance_mm)[:SHOWN]
    ]
    head = [
        "station",
        "ring",
        "dx mm",
        "dy mm",
        "dz mm",
        "off mm",
        "arcsec",
        "fitted mm",
        "chained mm",
        "ICP mm",
    ]
    return [
        f"Stations of {name}, the worst first" + _some(len(rows), len(found.entries)),
        *aligned(head, rows),
        f"RMS {number(found.rms_mm, 3)} mm, largest {number(found.largest_mm, 3)} mm, "
        f"{number(found.rms_arcsec, 2)} arcsec; after the best rigid fit of stations and "
        f"targets {number(found.fitted_rms_mm, 3)} mm (the paper's registration: 5 mm)",
        f"station by station {number(found.chained_rms_mm, 2)} mm, after its best fit "
        f"{number(found.chained_fitted_rms_mm, 2)} mm; pairwise ICP {number(found.icp_rms_mm, 2)} mm, after "
        f"its best fit {number(found.icp_fitted_rms_mm, 2)} mm",
        _sigma("positions", found.sigma),
    ]


def _targets(found: TargetErrors) -> list[str]:
    return [
        f"Targets: {found.matched} of {found.true} found, {found.false} false, "
        f"RMS {number(found.rms_mm, 3)} mm, largest {number(found.largest_mm, 3)} mm",
        _sigma("targets", found.sigma),
    ]


def _gross(found: GrossVerdict) -> list[str]:
    return [
        f"Gross errors: {len(found.named)} named, {len(found.missed)} missed, {len(found.false)} false",
        *(f"  {word}: {', '.join(listed)}" for word, listed in vars(found).items() if listed),
    ]


def _columns(found: ColumnErrors) -> list[str]:
    rows = [
        [
            row.name,
            number(row.found_mm, 2),
            number(row.true_mm, 2),
            number(row.deviation_error_mm, 2, sign=True),
            number(row.north_error_mm, 2, sign=True),
            number(row.east_error_mm, 2, sign=True),
            number(row.direction_error_deg, 2),
            number(row.sigma_mm, 2),
            ("over" if row.over else "within") + ("" if row.over == row.truly_over else " (wrong)"),
        ]
        for row in found.entries[:SHOWN]
    ]
    head = [
        "column",
        "found mm",
        "truth mm",
        "diff mm",
        "north mm",
        "east mm",
        "turn deg",
        "sigma mm",
        "limit",
    ]
    missing = f"; not judged: {', '.join(found.missing)}" if found.missing else ""
    return [
        "Columns" + _some(len(rows), len(found.entries)),
        *aligned(head, rows),
        f"deviation RMS {number(found.rms_mm, 3)} mm, largest {number(found.largest_mm, 3)} mm; components "
        f"RMS {number(found.component_rms_mm, 3)} mm, largest {number(found.component_largest_mm, 3)} mm",
        f"{found.right} judged right, {found.wrong} wrong; {found.over} over the limit, in truth "
        f"{found.truly_over}{missing}",
        _sigma("components", found.sigma),
    ]


def _nodes(found: NodeErrors) -> list[str]:
    worst = [row for row in found.entries if row.eccentric or row.significant]
    rows = [
        [
            row.name,
            row.found,
            number(row.found_mm, 2),
            number(row.true_mm, 2),
            number(row.amount_error_mm, 2, sign=True),
            number(row.error_mm, 2),
            number(row.sigma_mm, 2),
            _verdict(row.significant, row.eccentric),
        ]
        for row in sorted(worst, key=lambda row: -row.error_mm)[:SHOWN]
    ]
    head = ["node", "found as", "found mm", "truth mm", "diff mm", "vector mm", "sigma mm", "verdict"]
    return [
        "Eccentric nodes, the worst first" + _some(len(rows), len(worst)),
        *(aligned(head, rows) if rows else ()),
        f"{len(found.entries)} of {found.true} nodes judged, {found.eccentric} of them eccentric: "
        f"{found.missed} missed, {found.false} false ({number(found.false_percent, 1)} %)",
        *_amounts(found),
    ]


def _amounts(found: NodeErrors) -> list[str]:
    if not found.eccentric:
        return [f"balls RMS {number(found.ball_rms_mm, 3)} mm"]
    return [
        f"amount RMS {number(found.amount_rms_mm, 3)} mm, largest {number(found.amount_largest_mm, 3)} mm; "
        f"vector RMS {number(found.rms_mm, 3)} mm, largest {number(found.largest_mm, 3)} mm; balls RMS "
        f"{number(found.ball_rms_mm, 3)} mm",
        _sigma("amounts", found.sigma),
    ]


def _verdict(significant: bool, eccentric: bool) -> str:
    if significant == eccentric:
        return "right"
    return "false" if significant else "missed"


def _deflection(found: DeflectionErrors) -> str:
    return (
        f"Deflection: {found.nodes} nodes, RMS {number(found.rms_mm, 3)} mm, largest error "
        f"{number(found.largest_mm, 3)} mm; largest deflection {number(found.found_mm, 2)} mm, in truth "
        f"{number(found.true_mm, 2)} mm; verdict {'right' if found.verdict_right else 'wrong'}\n"
        + _sigma("deflections", found.sigma)
    )


def _members(kind: str, found: MemberErrors) -> str:
    return (
        f"{kind}: {found.found} of {found.true} found, {found.doubled} doubled, {found.false} false; place "
        f"RMS {number(found.place_rms_mm, 3)} mm, radius RMS {number(found.radius_rms_mm, 3)} mm "
        f"(median {number(found.radius_bias_mm, 3, sign=True)})"
    )


def _fusion(found: FusionErrors) -> str:
    return (
        f"Photos: {found.photos} of {found.true_photos} cameras, scale "
        f"{number(found.scale_percent, 4, sign=True)} %, places RMS {number(found.rms_mm, 2)} mm, largest "
        f"{number(found.largest_mm, 2)} mm, after the best rigid fit {number(found.fitted_rms_mm, 2)} mm; "
        f"cloud to cloud {number(found.median_mm, 2)} mm (median, the run's own)"
    )


def _sigma(what: str, found: SigmaCheck) -> str:
    return (
        f"sigma of the {what}: {number(found.over_rms, 2)} times the RMS error, "
        f"{number(found.within_percent, 1)} % of {found.count} within 2 sigma"
    )


def _some(shown: int, total: int) -> str:
    return f" ({shown} of {total})" if shown < total else ""
