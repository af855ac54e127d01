"""A report.json and a truth.json of a small steel survey that agree; tests spoil one value and look."""

import copy
import json
import math

import numpy as np

from pipeline.evaluate.documents import Document

STATIONS = 5
COLUMNS = {"8-N": (17.3, 32.1), "7-P": (-11.9, 37.3), "6-Q": (3.0, -4.0)}  # east, north, mm
SAG_MM = (0.0, 4.0, 9.0, 4.0, 0.0)


def turned(arcsec, axis=2):
    """A small rotation about one axis."""
    a = math.radians(arcsec / 3600)
    i, j = [k for k in range(3) if k != axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = math.cos(a)
    matrix[i, j], matrix[j, i] = -math.sin(a), math.sin(a)
    return matrix


def truth():
    """Stations in a row, targets beside them, a grid of 5 x 3 balls, three columns."""
    balls = [(3.0 * i, 3.0 * j, 6.0 - SAG_MM[i] / 1000 * (j == 1)) for i in range(5) for j in range(3)]
    return {
        "format": 1,
        "kind": "steel",
        "stations": [
            {"name": f"S{n:02d}", "rotation": turned(3600.0 * n).tolist(), "translation": place(n)}
            for n in range(STATIONS)
        ],
        "targets": [
            {"name": f"T{n:02d}", "position_m": [4.0 * n, 5.0 * (-1) ** n, 1.5 + n / 10]} for n in range(8)
        ],
        "rods": [
            {"name": "a", "start_m": [0, 0, 6], "end_m": [3, 0, 6], "radius_mm": 30.0, "nodes": ["B0", "B3"]},
            {"name": "b", "start_m": [3, 0, 6], "end_m": [6, 0, 6], "radius_mm": 30.0, "nodes": ["B3", "B6"]},
        ],
        "nodes": [
            {
                "name": f"B{n}",
                "ball_m": list(ball),
                "rods_m": list(ball),
                "radius_mm": 100.0,
                "eccentricity_mm": [6.0, 8.0, 0.0] if n in (0, 1) else [0.0, 0.0, 0.0],
            }
            for n, ball in enumerate(balls)
        ],
        "columns": [
            {
                "name": name,
                "bottom_m": [6.0 * n, 0.0, 0.5],
                "top_m": [6.0 * n + east / 1000, north / 1000, 14.5],
                "radius_mm": 150.0,
                "tilt_mm": [east, north],
                "height_m": 14.0,
                "over_limit": math.hypot(east, north) > 35,
            }
            for n, (name, (east, north)) in enumerate(COLUMNS.items())
        ],
        "gross": [],
        "span_m": 12.0,
    }  # fmt: skip


def place(number):
    return [10.0 * number, 0.5 * (number % 2), 0.1 * number]


def perfect():
    """What a run without errors would write, all sigmas 1 mm."""
    true = truth()
    return {
        "format": 1,
        "kind": "steel",
        "name": "hall",
        "stations": [
            {
                "name": row["name"],
                "position_m": row["translation"],
                "rotation": row["rotation"],
                "sigma_xyz_mm": [1.0 * bool(n)] * 3,
                "ring": n,
            }
            for n, row in enumerate(true["stations"])
        ],
        "targets": [{**row, "kind": "point", "sigma_mm": 1.0} for row in true["targets"]],
        "gross": [],
        "comparison": [
            {
                "station": f"S{n:02d}",
                "chained": {"position_m": [10.0 * n + 0.003 * n, *place(n)[1:]]},
                "icp": None,
            }
            for n in range(STATIONS)
        ],
        "nodes": [
            {
                "name": f"N{n}",
                "ball_m": row["ball_m"],
                "eccentricity_mm": row["eccentricity_mm"],
                "size_mm": float(np.linalg.norm(row["eccentricity_mm"])),
                "sigma_mm": 0.3,
                "significant": n in (0, 1),
            }
            for n, row in enumerate(true["nodes"])
        ],
        "members": {
            "rods": [
                {key: row[key] for key in ("name", "start_m", "end_m", "radius_mm")} for row in true["rods"]
            ],
            "balls": [
                {"name": row["name"], "centre_m": row["ball_m"], "radius_mm": 100.0} for row in true["nodes"]
            ],
            "columns": [],
        },
        "columns": [
            {
                "name": row["name"],
                "bottom_m": row["bottom_m"],
                "east_mm": row["tilt_mm"][0],
                "north_mm": row["tilt_mm"][1],
                "east_sigma_mm": 0.5,
                "north_sigma_mm": 0.5,
                "deviation_mm": math.hypot(*row["tilt_mm"]),
                "sigma_mm": 0.5,
                "over_limit": row["over_limit"],
            }
            for row in true["columns"]
        ],
        "deflection": {
            "limit_mm": 48.0,
            "largest_mm": 9.0,
            "over_limit": False,
            "rows": [
                {
                    "node": f"N{n}",
                    "position_m": row["ball_m"],
                    "deflection_mm": SAG_MM[n // 3] * (n % 3 == 1),
                    "sigma_mm": 0.4,
                    "support": n % 3 != 1,
                }
                for n, row in enumerate(true["nodes"])
            ],
        },
    }  # fmt: skip


def case(spoil=None, change=None):
    """(report, truth) as documents, after ``spoil(report)`` and ``change(truth)``."""
    report, true = copy.deepcopy(perfect()), copy.deepcopy(truth())
    if spoil:
        spoil(report)
    if change:
        change(true)
    return document(report, "report.json"), document(true, "truth.json")


def document(values, name):
    return Document(file=name, where="", values=json.loads(json.dumps(values)))
