"""The true surface as a fine quad mesh; pure numpy.

Takes the cable, gives vertices, quads and texture coordinates.  The grid turns with the fillets, so that
their small curvature is resolved around the girth only and the rows along the axis may be coarse.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.spec import Cable, Defect, Robot
from synth.surface import axis_m, base_radius_m, largest_radius_m, radius_m

GIRTH_CHORD_ERROR_M = 1.0e-6  # of the 0.002 mm allowed, along the diagonal of a quad
RIB_CHORD_ERROR_M = 0.6e-6
DEFECT_CHORD_ERROR_M = 0.3e-6
PROFILE_CHORD_ERROR_M = 0.2e-6
LONGEST_ROW_STEP_M = 0.002
LEAST_STEP_M = 1.0e-5
SMOOTHSTEP_CURVATURE = 5.774  # largest second derivative of the fifth-degree smoothstep, 10 / sqrt(3)


@dataclass(frozen=True, kw_only=True)
class CableMesh:
    """A closed tube, open at its ends.

    Attributes:
        vertices: (v, 3) float64, cable frame, metres.
        quads: (q, 4) int32 vertex numbers, outward by the right-hand rule.
        uv: (q, 4, 2) float32 texture coordinates of the corners: girth and length, 0 to 1.
    """

    vertices: Array
    quads: NDArray[np.int32]
    uv: NDArray[np.float32]


def cable_mesh(cable: Cable, robot: Robot) -> CableMesh:
    """Mesh the cable from one margin to the other, chord error below 0.002 mm."""
    start, end = -cable.margin_m, robot.travel_m + cable.margin_m
    y = _rows_along(cable, start, end)
    around = _angles_around(cable)
    twist = 2.0 * math.pi * y / cable.fillet.pitch_m if cable.fillet is not None else np.zeros_like(y)
    azimuth = around[None, :] + twist[:, None]
    radius = radius_m(cable, azimuth, y[:, None])
    axis_x, axis_z = axis_m(cable, robot.travel_m, y[:, None])
    x, z = axis_x + radius * np.cos(azimuth), axis_z - radius * np.sin(azimuth)
    vertices = np.stack([x, np.broadcast_to(y[:, None], radius.shape), z], axis=-1)
    rows, columns = len(y), len(around)
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    following = (column + 1) % columns
    quads = np.stack(
        [
            row * columns + column,
            row * columns + following,
            (row + 1) * columns + following,
            (row + 1) * columns + column,
        ],
        axis=-1,
    ).reshape(-1, 4)
    closed = np.append(around, around[0] + 2.0 * math.pi)
    u = (closed[None, :] + twist[:, None]) / (2.0 * math.pi)
    v = np.broadcast_to(((y - start) / (end - start))[:, None], u.shape)
    grid = np.stack([u, v], axis=-1)
    uv = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2)
    return CableMesh(
        vertices=vertices.reshape(-1, 3),
        quads=quads.astype(np.int32),
        uv=uv.reshape(-1, 4, 2).astype(np.float32),
    )


def _rows_along(cable: Cable, start: float, end: float) -> Array:
    """Positions of the rows: even, and denser across the defects."""
    even = np.linspace(start, end, math.ceil((end - start) / _row_step_m(cable)) + 1)
    rows = [even]
    for defect in cable.defect:
        half_m = defect.length_mm / 2000.0
        count = _steps_across(defect, 2.0 * half_m)
        rows.append(defect.position_m + np.linspace(-half_m, half_m, count + 1))
    y = np.unique(np.clip(np.concatenate(rows), start, end))
    return _apart(y, LEAST_STEP_M)


def _apart(places: Array, least: float) -> Array:
    """Sorted places without those that follow the one before too closely: no slivers."""
    return places[np.append(True, np.diff(places) > least)]


def _steps_across(defect: Defect, length_m: float) -> int:
    """Steps across a defect of this size: h (1 - s^2)^3 curves by 6 h over the square of the half size."""
    curvature = 6.0 * defect.height_mm / 1000.0 / (length_m / 2.0) ** 2
    return math.ceil(length_m / math.sqrt(8.0 * DEFECT_CHORD_ERROR_M / curvature))


def _girth_step_rad(cable: Cable) -> float:
    """Angle that the diagonal of a quad may span: sagitta r d^2 / 8."""
    return math.sqrt(8.0 * GIRTH_CHORD_ERROR_M / largest_radius_m(cable))


def _row_step_m(cable: Cable) -> float:
    """Distance of the rows: fine enough for the steepest change of the profile and for the twist."""
    step_m = LONGEST_ROW_STEP_M
    for a, b in itertools.pairwise(cable.station):
        if a.diameter_mm is not None and b.diameter_mm is not None and a.diameter_mm != b.diameter_mm:
            rise_m, length_m = abs(b.diameter_mm - a.diameter_mm) / 2000.0, b.position_m - a.position_m
            curvature = SMOOTHSTEP_CURVATURE * rise_m / length_m**2
            step_m = min(step_m, math.sqrt(8.0 * PROFILE_CHORD_ERROR_M / curvature))
    if cable.fillet is not None:
        step_m = min(step_m, 0.5 * _girth_step_rad(cable) * cable.fillet.pitch_m / (2.0 * math.pi))
    return step_m


def _angles_around(cable: Cable) -> Array:
    """Azimuths of the columns: even, and denser across the fillets."""
    fillet = cable.fillet
    step = _girth_step_rad(cable) * (1.0 if fillet is None else 0.5)  # the twist takes the other half
    even = np.linspace(0.0, 2.0 * math.pi, math.ceil(2.0 * math.pi / step), endpoint=False)
    if fillet is None:
        around = np.sort(np.concatenate([even, *_across_defects(cable)]) % (2.0 * math.pi))
        return _apart(around, LEAST_STEP_M / base_radius_m(cable))
    width_m, height_m = fillet.width_mm / 1000.0, fillet.height_mm / 1000.0
    curvature = 2.0 * height_m * (math.pi / width_m) ** 2  # of h cos^2(pi s / w) at its crest
    count = math.ceil(width_m / math.sqrt(8.0 * RIB_CHORD_ERROR_M / curvature))
    half_rad = 0.5 * width_m / base_radius_m(cable)
    first = math.radians(fillet.angle_deg)
    ribs = [first + turn + np.linspace(-half_rad, half_rad, count + 1) for turn in (0.0, math.pi)]
    gap = np.abs((even - first + math.pi / 2.0) % math.pi - math.pi / 2.0)
    return np.sort(np.concatenate([even[gap > half_rad + 0.2 * step], *ribs]) % (2.0 * math.pi))


def _across_defects(cable: Cable) -> list[Array]:
    """Further azimuths, across each defect."""
    further = []
    for defect in cable.defect:
        half_rad = defect.width_mm / 2000.0 / base_radius_m(cable)
        count = _steps_across(defect, defect.width_mm / 1000.0)
        further.append(math.radians(defect.azimuth_deg) + np.linspace(-half_rad, half_rad, count + 1))
    return further
