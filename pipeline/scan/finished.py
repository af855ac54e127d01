"""A finished cable run, as far as a scan is held against it: read from what the run wrote for everybody.

Takes RUN/cloud.ply, radius_map.npz and report.json; gives points with normals and colours, the joined surface
and the stations.  Leaves out the products of the stages.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import PhotoCloud

STAGE = "scan"


@dataclass(frozen=True, kw_only=True)
class FinishedRun:
    """What a run has made of a cable; cable frame.

    Attributes:
        name: of the survey.
        cloud: dense points, metres.
        theta: (m,) azimuths of the surface's columns, radians, from +x towards -z.
        position_m: (n,) of its rows along the axis.
        radius_mm: (n, m), NaN where unknown.
        stations: name, position_m, diameter_mm, sigma_mm and more of each, as report.json has them.
    """

    name: str
    cloud: PhotoCloud
    theta: Array
    position_m: Array
    radius_mm: Array
    stations: tuple[dict[str, object], ...]

    @property
    def radius_m(self) -> float:
        """Median radius."""
        return float(np.nanmedian(self.radius_mm)) / 1000

    @property
    def middle_m(self) -> float:
        """Middle of the surface along the axis."""
        return float(self.position_m[0] + self.position_m[-1]) / 2


def read_finished_run(folder: Path) -> FinishedRun:
    """Read a finished cable run.

    Raises:
        StageError: the folder is no finished run of a cable; says what is missing.
    """
    if not folder.is_dir():
        raise StageError(STAGE, f"{folder} does not exist", "name the folder of a finished run")
    for file in ("report.json", "cloud.ply", "radius_map.npz"):
        if not (folder / file).is_file():
            raise StageError(
                STAGE,
                f"{folder} is no finished run of a cable: it has no {file}",
                "run the survey to its end",
            )
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        with np.load(folder / "radius_map.npz", allow_pickle=False) as surface:
            theta, y, radius = (surface[k].astype(float) for k in ("theta_deg", "position_m", "radius_mm"))
        cloud = _cloud(folder / "cloud.ply")
        name, stations = str(report["name"]), tuple(report["stations"])
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise StageError(
            STAGE, f"what {folder} holds cannot be read ({str(error)[:100]})", "run the survey again"
        ) from error
    return FinishedRun(
        name=name, cloud=cloud, theta=np.radians(theta), position_m=y, radius_mm=radius, stations=stations
    )


def _cloud(path: Path) -> PhotoCloud:
    from plyfile import PlyData, PlyParseError

    try:
        rows = PlyData.read(str(path))["vertex"].data
    except PlyParseError as error:
        raise ValueError(f"cloud.ply: {error}") from error

    def columns(names: tuple[str, ...]) -> Array:
        return np.column_stack([rows[name] for name in names]).astype(float)

    return PhotoCloud(
        points=columns(("x", "y", "z")),
        normals=columns(("nx", "ny", "nz")),
        colours=columns(("red", "green", "blue")).astype(np.uint8),
        sigmas=np.zeros(0),
    )
