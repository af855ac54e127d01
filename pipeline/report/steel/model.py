"""The fitted structure as coloured triangles: members.glb and members.ply.

Takes a :class:`SteelReport`; gives named shapes (rods, balls, columns, arrows) and the bytes of both files.
Balls are vermillion where their eccentricity is significant, columns where they lean more than they may.
"""

import math

import numpy as np
import trimesh

from pipeline.core.vocabulary import Array
from pipeline.report.steel import colours
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.scaling import largest, round_factor
from pipeline.report.steel.shapes import Shape, arrow, ball, tube
from pipeline.report.steel.structure_rows import ColumnRow, Place

ECCENTRICITY_ARROW_M, LEAN_ARROW_M = 0.6, 2.0
"""About how long the longest arrow of each kind is drawn."""
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rows right-multiplied by this go from z up to glTF's y up; Blender's import turns them back."""


def shapes(report: SteelReport) -> dict[str, Shape]:
    """Name to triangles, of what there is; the arrows' names tell how many times larger they are drawn."""
    lean, apart = lean_factor(report), eccentricity_factor(report)
    painted = {row.name: colours.of_column(row) for row in report.columns}
    nodes = {row.name: colours.of_node(row) for row in report.nodes}
    steel = colours.rgb(colours.STEEL)
    found = {
        "rods": [tube(r.start_m, r.end_m, r.radius_mm / 1000, steel, 12) for r in report.rods],
        "balls": [
            ball(b.centre_m, b.radius_mm / 1000, colours.rgb(nodes.get(b.name, colours.UNKNOWN)))
            for b in report.balls
        ],
        "columns": [
            tube(c.bottom_m, c.top_m, c.radius_mm / 1000, colours.rgb(painted[c.name]), 24)
            for c in report.columns
            if known(c.top_m) and math.isfinite(c.radius_mm)
        ]
        or [tube(c.start_m, c.end_m, c.radius_mm / 1000, steel, 24) for c in report.uprights],
        f"eccentricity x{apart}": [
            arrow(start, end, 0.02, colours.rgb(colours.BAD)) for start, end in eccentricity_arrows(report)
        ],
        f"lean x{lean}": [
            arrow(start, end, 0.05, colours.rgb(colours.of_column(row)))
            for row, (start, end) in lean_arrows(report)
        ],
    }
    return {name: Shape.joined(parts) for name, parts in found.items() if parts}


def lean_factor(report: SteelReport) -> int:
    """How many times larger the columns' lean is drawn in space."""
    return round_factor(largest(row.deviation_mm for row in report.columns), LEAN_ARROW_M)


def eccentricity_factor(report: SteelReport) -> int:
    """How many times larger eccentricities are drawn in space."""
    return round_factor(largest(row.size_mm for row in report.nodes if row.significant), ECCENTRICITY_ARROW_M)


def eccentricity_arrows(report: SteelReport) -> list[tuple[Array, Array]]:
    """Start and end, m, of the significant nodes' arrows: from where the rods meet towards the ball."""
    factor = eccentricity_factor(report)
    return [
        (np.array(row.rods_m), np.array(row.rods_m) + factor * np.array(row.eccentricity_mm) / 1000)
        for row in report.nodes
        if row.significant and known(row.rods_m)
    ]


def lean_arrows(report: SteelReport) -> list[tuple[ColumnRow, tuple[Array, Array]]]:
    """Each column with start and end, m, of its arrow: at the top, level, towards where it leans."""
    factor = lean_factor(report)
    found = []
    for row in report.columns:
        if not known(row.top_m) or not math.isfinite(row.deviation_mm):
            continue
        step = np.array(row.top_m) - np.array(row.bottom_m)
        found.append((row, (np.array(row.top_m), np.array(row.top_m) + factor * step * [1, 1, 0])))
    return found


def known(place: Place) -> bool:
    """Whether a place is one."""
    return all(math.isfinite(value) for value in place)


def glb_bytes(found: dict[str, Shape]) -> bytes:
    """All shapes as one binary glTF, each under its name; y is up there, as glTF demands."""
    scene = trimesh.Scene()
    for name, shape in found.items():
        scene.add_geometry(_mesh(shape, shape.vertices @ _Y_UP), node_name=name, geom_name=name)
    return bytes(trimesh.exchange.gltf.export_glb(scene, include_normals=True))


def ply_bytes(found: dict[str, Shape]) -> bytes:
    """All shapes as one binary PLY with a colour a vertex; z is up."""
    shape = Shape.joined(list(found.values()))
    return bytes(trimesh.exchange.ply.export_ply(_mesh(shape, shape.vertices), vertex_normal=False))


def _mesh(shape: Shape, vertices: Array) -> trimesh.Trimesh:
    return trimesh.Trimesh(
        vertices=vertices, faces=shape.faces, vertex_colors=shape.colours, process=False, validate=False
    )
