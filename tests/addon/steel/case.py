"""A steel run without clouds, and the same with members and points written by hand."""

import json
import shutil

import numpy as np

from tests.command import ROOT, pipeline, synth

SPEC = ROOT / "specs" / "steel" / "gross.toml"
"""Lists of targets only; one target moved, one misnamed."""

TOP_M = 5.0
LEAN_MM = {"A-1": (40.0, 30.0), "A-2": (3.0, 0.0), "B-1": (35.2, 0.0)}
"""Lean of each column, x and y; the limit is 35 mm."""
PLACES = {"A-1": (0.0, 0.0), "A-2": (6.0, 0.0), "B-1": (0.0, 6.0)}
APART_MM = {"N01": (0.2, 0.1, -0.3), "N02": (-6.0, 8.0, 0.0), "N03": (0.0, 3.0, 4.0)}
"""Ball minus rods; N01 is no eccentricity."""
STATION_COLOURS = ((200, 40, 10), (10, 120, 240))


def scanned(folder):
    """Survey and lists of targets of the specification."""
    done = synth("scan", SPEC, folder)
    assert done.code == 0, done.stderr[-2000:]
    return folder


def registered(survey_folder, run):
    """A run of it by the command line."""
    done = pipeline("steel", survey_folder / "survey.toml", "--out", run, "--events", "none")
    assert done.code == 0, done.stderr[-2000:]
    return run


def with_members(run, folder):
    """A copy of the run that has a space frame of three columns, three balls, two rods, and points."""
    shutil.copytree(run, folder)
    path = folder / "report.json"
    tree = json.loads(path.read_text())
    tree["nodes"] = [_node(name) for name in APART_MM]
    tree["columns"] = [_column(name) for name in LEAN_MM]
    balls = [node["ball_m"] for node in tree["nodes"]]
    tree["members"]["rods"] = [
        {"name": f"R0{k}", "start_m": balls[k - 1], "end_m": balls[k], "radius_mm": 30.0} for k in (1, 2)
    ]
    tree["members"]["columns"] = [
        # that of A-1, and one that nobody asked for
        {"name": "C01", "start_m": [0.02, 0.01, 0.1], "end_m": [0.05, 0.03, 4.9], "radius_mm": 150.0},
        {"name": "C02", "start_m": [6.0, 6.0, 0.0], "end_m": [6.0, 6.0, 5.0], "radius_mm": 150.0},
    ]
    tree["deflection"] = {
        "span_m": 6.0,
        "limit_mm": 24.0,
        "largest_mm": 12.5,
        "largest_node": "N03",
        "largest_sigma_mm": 0.4,
        "over_limit": False,
        "rows": [],
    }
    path.write_text(json.dumps(tree))
    write_cloud(folder / "cloud.ply", cloud_points())
    return folder


def ball_place(name):
    """Where the ball of a node is, metres."""
    return np.array([3.0 * list(APART_MM).index(name), 1.0, TOP_M])


def top_place(name):
    """The top of a column, metres."""
    return np.array([*PLACES[name], TOP_M]) + np.array([*LEAN_MM[name], 0.0]) / 1000


def cloud_points():
    """(n, 3) places of each of two stations."""
    draw = np.random.default_rng(3)
    return [draw.uniform(-2, 2, (count, 3)) for count in (700, 300)]


def write_cloud(path, stations):
    """cloud.ply as the report writes it."""
    names = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
    rows = np.zeros(sum(map(len, stations)), dtype=np.dtype([*names, ("station", "<u2")]))
    for column, key in enumerate("xyz"):
        rows[key] = np.concatenate(stations)[:, column]
    rows["station"] = np.repeat(range(len(stations)), [len(points) for points in stations])
    for column, key in enumerate(("red", "green", "blue")):
        rows[key] = np.array(STATION_COLOURS)[rows["station"], column]
    words = {"<f4": "float", "|u1": "uchar", "<u2": "ushort"}
    told = [f"property {words[rows.dtype[key].str]} {key}" for key in rows.dtype.names]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *told, "end_header\n"]
    path.write_bytes("\n".join(head).encode() + rows.tobytes())


def _node(name):
    apart = np.array(APART_MM[name])
    size, ball = float(np.linalg.norm(apart)), ball_place(name)
    return {
        "name": name,
        "ball_m": ball.tolist(),
        "radius_mm": 100.0,
        "rods_m": (ball - apart / 1000).tolist(),
        "eccentricity_mm": apart.tolist(),
        "size_mm": size,
        "sigma_mm": 0.2,
        "significant": size > 1,
        "rods": ["R01", "R02"],
    }


def _column(name):
    x, y = PLACES[name]
    size = float(np.hypot(*LEAN_MM[name]))
    return {
        "name": name,
        "bottom_m": [x, y, 0.0],
        "top_m": top_place(name).tolist(),
        "radius_mm": 150.0,
        "deviation_mm": size,
        "sigma_mm": 0.3,
        "direction": "north-east",
        "direction_deg": 45.0,
        "ratio": 1000 * TOP_M / size,
        "limit_mm": 35.0,
        "over_limit": size > 35,
        "certain": abs(size - 35) > 0.6,
    }
