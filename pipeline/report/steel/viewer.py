"""What the 3D view of the steel page needs: axes, radii and colours; the browser makes the triangles.

Takes a :class:`SteelReport`; gives the element with the record that viewer.js reads.  A hall of a thousand
rods is some 100 kB that way.
"""

import json
import math
from typing import Any

from pipeline.report.markup import Writer
from pipeline.report.steel import colours, model
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.structure_rows import Place

BOXES = ("rods", "balls", "columns", "arrows", "stations", "names")


def viewer_element(writer: Writer, report: SteelReport) -> str:
    """The canvas, its switches and its record."""
    boxes = "".join(
        f'<label><input type="checkbox" name="{box}" checked>{writer.say(f"steel_viewer_{box}")}</label>'
        for box in BOXES
    )
    missing = writer.say("steel_viewer_missing", "p", 'class="missing"')
    # A "<" could end the script element that holds the record.
    text = json.dumps(viewer_record(report), ensure_ascii=False, separators=(",", ":")).replace(
        "<", "\\u003c"
    )
    return (
        '<div id="viewer"><canvas tabindex="0"></canvas><div class="ring-labels"></div>'
        f'<div class="controls">{boxes}</div>{missing}<noscript>{missing}</noscript></div>'
        f'<script type="application/json" id="viewer-data">{text}</script>'
    )


def viewer_record(report: SteelReport) -> dict[str, Any]:
    """Tubes are (start, end, radius, colour), balls (centre, radius, colour), in m, rounded to 0.1 mm."""
    steel = colours.STEEL
    found = {row.name: row for row in report.nodes}
    judged = [row for row in report.columns if model.known(row.top_m) and math.isfinite(row.radius_mm)]
    return {
        "rods": [_tube(r.start_m, r.end_m, r.radius_mm, steel) for r in report.rods],
        "balls": [
            _ball(
                b.centre_m,
                b.radius_mm,
                colours.of_node(found[b.name]) if b.name in found else colours.UNKNOWN,
            )
            for b in report.balls
        ],
        "columns": [_tube(c.bottom_m, c.top_m, c.radius_mm, colours.of_column(c)) for c in judged]
        or [_tube(c.start_m, c.end_m, c.radius_mm, steel) for c in report.uprights],
        "arrows": [
            *(
                _tube(start.tolist(), end.tolist(), 60, colours.of_column(row))
                for row, (start, end) in model.lean_arrows(report)
            ),
            *(
                _tube(start.tolist(), end.tolist(), 25, colours.BAD)
                for start, end in model.eccentricity_arrows(report)
            ),
        ],
        "stations": [_ball(row.position_m, 160, colours.STATION) for row in report.stations],
        "names": [
            *(
                {"name": row.name, "text": f"{row.deviation_mm:.1f} mm", "place": _rounded(row.top_m)}
                for row in judged
            ),
            *(
                {"name": row.name, "text": f"{row.size_mm:.1f} mm", "place": _rounded(row.ball_m)}
                for row in report.nodes
                if row.significant
            ),
        ],
    }


def _tube(start: Place | list[float], end: Place | list[float], radius_mm: float, colour: str) -> list[Any]:
    return [*_rounded(start), *_rounded(end), round(radius_mm / 1000, 4), colour]


def _ball(centre: Place, radius_mm: float, colour: str) -> list[Any]:
    return [*_rounded(centre), round(radius_mm / 1000, 4), colour]


def _rounded(place: Place | list[float]) -> list[float]:
    return [round(value, 4) for value in place]
