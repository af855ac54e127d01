"""What a finished steel run tells, read from its report.json for everybody: no product, no library of scans.

Takes the run folder; gives the rows of ``steel_rows`` in metres and millimetres, or one sentence.
Needs no bpy.
"""

import json
import math
from pathlib import Path
from typing import Any

from pipeline.core.errors import StageError

from .steel_rows import Column, Gross, Node, Place, Rows, Sag, Station, SteelRows, Target, Tube


def read_steel(folder: Path) -> SteelRows:
    """Read the report of a steel run.

    Raises:
        StageError: it is no steel run, not finished, or damaged.
    """
    folder = folder.absolute()
    tree = _report(folder)
    try:
        columns = tuple(_column(row) for row in tree["columns"])
        uprights = tuple(_tube(row) for row in tree["members"]["columns"])
        return SteelRows(
            folder=folder,
            stations=tuple(_station(row) for row in tree["stations"]),
            targets=tuple(
                Target(name=row["name"], kind=row["kind"], place=_place(row["position_m"]))
                for row in tree["targets"]
            ),
            gross=_gross(tree["gross"]),
            rods=tuple(_tube(row) for row in tree["members"]["rods"]),
            uprights=tuple(u for u in uprights if not any(_same(u, c.axis) for c in columns)),
            nodes=tuple(_node(row) for row in tree["nodes"]),
            columns=columns,
            sag=_sag(tree["deflection"]),
            warnings=tuple(str(words) for words in tree["warnings"]),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise StageError(
            "run",
            f"report.json of {folder.name} is damaged or of another version of this program",
            "run the reconstruction again",
        ) from error


def is_steel(folder: Path) -> bool:
    """Whether a folder holds a steel run, finished or not."""
    products = folder / "products"
    return any(found for stage in ("clouds", "targets") for found in products.glob(f"*-{stage}.npz"))


def _report(folder: Path) -> dict[str, Any]:
    path = folder / "report.json"
    try:
        tree = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise _without_report(folder) from error
    except (OSError, ValueError) as error:
        raise StageError("run", f"{path} cannot be read", "run the reconstruction again") from error
    if not isinstance(tree, dict) or tree.get("kind") != "steel":
        raise StageError(
            "run", f"{folder} is the run of a cable, not of a steel structure", "open it in the panel Results"
        )
    return tree


def _without_report(folder: Path) -> StageError:
    if is_steel(folder):
        return StageError("run", f"the run in {folder} is not finished", "run the reconstruction to its end")
    if (folder / "products").is_dir():
        return StageError(
            "run", f"{folder} is the run of a cable, not of a steel structure", "open it in the panel Results"
        )
    return StageError("run", f"{folder} is no run folder", "choose a folder that a reconstruction wrote")


def _station(row: dict[str, Any]) -> Station:
    return Station(
        name=row["name"],
        place=_place(row["position_m"]),
        rotation=_matrix(row["rotation"]),
        covariance_mm2=_matrix(row["covariance_mm2"]),
        sigma_mm=_number(row["sigma_mm"]),
    )


def _gross(rows: list[dict[str, Any]]) -> tuple[Gross, ...]:
    """A target that was moved is one thing, however many stations saw it; a wrong name is each station's."""
    found: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in rows:
        moved = row["kind"] == "moved"
        key = (row["target"], row["kind"], *(sorted(row["together"]) if moved else (row["station"],)))
        found.setdefault(key, []).append(row)
    return tuple(
        Gross(
            target=same[0]["target"],
            kind=same[0]["kind"],
            stations=tuple(sorted({s for row in same for s in (row["station"], *row["together"])})),
            offset_mm=_place(same[0]["offset_mm"]),
            size_mm=_number(same[0]["size_mm"]),
            fits=same[0]["fits"],
        )
        for same in found.values()
    )


def _tube(row: dict[str, Any]) -> Tube:
    return Tube(
        name=row["name"],
        start=_place(row["start_m"]),
        end=_place(row["end_m"]),
        radius_m=_number(row["radius_mm"]) / 1000,
    )


def _node(row: dict[str, Any]) -> Node:
    return Node(
        name=row["name"],
        ball=_place(row["ball_m"]),
        radius_m=_number(row["radius_mm"]) / 1000,
        rods=_place(row["rods_m"]),
        eccentricity_mm=_place(row["eccentricity_mm"]),
        size_mm=_number(row["size_mm"]),
        sigma_mm=_number(row["sigma_mm"]),
        significant=bool(row["significant"]),
    )


def _column(row: dict[str, Any]) -> Column:
    return Column(
        name=row["name"],
        axis=Tube(
            name=row["name"],
            start=_place(row["bottom_m"]),
            end=_place(row["top_m"]),
            radius_m=_number(row["radius_mm"]) / 1000,
        ),
        deviation_mm=_number(row["deviation_mm"]),
        sigma_mm=_number(row["sigma_mm"]),
        direction=row["direction"],
        ratio=_number(row["ratio"]),
        limit_mm=_number(row["limit_mm"]),
        over=bool(row["over_limit"]),
        certain=bool(row["certain"]),
    )


def _sag(row: dict[str, Any] | None) -> Sag | None:
    if row is None:
        return None
    return Sag(
        largest_mm=_number(row["largest_mm"]),
        limit_mm=_number(row["limit_mm"]),
        node=row["largest_node"],
        over=bool(row["over_limit"]),
    )


def _same(upright: Tube, judged: Tube) -> bool:
    """Whether a fitted column stands where a judged one does: closer than their radii together."""
    middle = [(a + b) / 2 for a, b in zip(upright.start, upright.end, strict=True)]
    centre = [(a + b) / 2 for a, b in zip(judged.start, judged.end, strict=True)]
    return math.dist(middle[:2], centre[:2]) < upright.radius_m + judged.radius_m


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _place(values: list[float | None]) -> Place:
    x, y, z = (_number(value) for value in values)
    return x, y, z


def _matrix(rows: list[list[float | None]]) -> Rows:
    a, b, c = (_place(row) for row in rows)
    return a, b, c
