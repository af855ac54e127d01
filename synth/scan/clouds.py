"""Cloud files: E57, LAS, LAZ, PLY, PTS, XYZ.  Takes points and intensities, gives a file; reads nothing."""

from datetime import date
from pathlib import Path

import numpy as np

from pipeline.core.vocabulary import Array
from synth.scan.spec import CloudFormat, Unit

LAS_STEP_M = 0.00005
PTS_FULL = 2047  # Leica's intensities run from -2048 to 2047


def write_cloud(path: Path, points: Array, intensity: Array, kind: CloudFormat, unit: Unit) -> None:
    """Write one cloud.

    Args:
        path: of the file.
        points: (n, 3) metres.
        intensity: (n,) 0..1.
        kind: format.
        unit: of the coordinates in the file.
    """
    scale = 1000.0 if unit == Unit.MILLIMETRE else 1.0
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.stem}.part{path.suffix}")
    _WRITERS[kind](temporary, points * scale, intensity, scale)
    temporary.replace(path)


def _e57(path: Path, points: Array, intensity: Array, scale: float) -> None:
    import pye57

    columns = {f"cartesian{axis}": np.ascontiguousarray(points[:, i]) for i, axis in enumerate("XYZ")}
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(
            {**columns, "intensity": intensity.astype(np.float32)}, name=path.stem.removesuffix(".part")
        )


def _las(path: Path, points: Array, intensity: Array, scale: float) -> None:
    import laspy

    header = laspy.LasHeader(version="1.2", point_format=0)
    header.creation_date = date(2026, 1, 1)  # the same bytes every day
    header.scales = np.full(3, LAS_STEP_M * scale)
    header.offsets = np.zeros(3)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    cloud.intensity = np.rint(65535.0 * intensity).astype(np.uint16)
    cloud.write(str(path))


def _ply(path: Path, points: Array, intensity: Array, scale: float) -> None:
    from plyfile import PlyData, PlyElement

    vertices = np.empty(len(points), [(name, "<f4") for name in ("x", "y", "z", "intensity")])
    vertices["x"], vertices["y"], vertices["z"] = points.T
    vertices["intensity"] = intensity
    PlyData([PlyElement.describe(vertices, "vertex")], byte_order="<").write(str(path))


def _pts(path: Path, points: Array, intensity: Array, scale: float) -> None:
    rows = np.column_stack([points, np.rint((2.0 * intensity - 1.0) * PTS_FULL)])
    np.savetxt(path, rows, fmt=["%.5f"] * 3 + ["%d"], header=str(len(rows)), comments="")


def _xyz(path: Path, points: Array, intensity: Array, scale: float) -> None:
    np.savetxt(path, np.column_stack([points, intensity]), fmt=["%.5f"] * 3 + ["%.4f"])


_WRITERS = {
    CloudFormat.E57: _e57,
    CloudFormat.LAS: _las,
    CloudFormat.LAZ: _las,
    CloudFormat.PLY: _ply,
    CloudFormat.PTS: _pts,
    CloudFormat.XYZ: _xyz,
}
