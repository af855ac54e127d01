"""A lens calibrated from pictures of a chessboard.

Takes a folder of pictures and the number of inner corners; gives focal length, principal point and lambda
with standard deviations.  Corners are OpenCV's, the adjustment is our own
(:mod:`pipeline.cable.chessboard_model`).  Leaves out the distortion's centre as a value of its own: it is the
principal point.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf
from pathlib import Path

import cv2
import numpy as np

from pipeline.cable.chessboard_model import BoardModel
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, silent
from pipeline.core.files import natural_key
from pipeline.core.fits.robust import FitOptions, Loss, solve
from pipeline.core.vocabulary import Array, LambdaRadius, Lens

ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
FEWEST_VIEWS = 3
"""Two give numbers, three a check on them."""


@dataclass(frozen=True, kw_only=True)
class BoardView:
    """One picture of the board: its file and (n, 2) corners in pixels, in the order of the board."""

    file: Path
    corners_px: Array


@dataclass(frozen=True, kw_only=True)
class ChessboardCalibration:
    """A calibrated lens.

    Attributes:
        lens: with sigmas of focal length and lambda (half-diagonal).
        principal_point_sigma_px: standard deviations of the principal point.
        noise_px: standard deviation of a corner's coordinate.
        used: pictures in which the board was found.
        unused: pictures in which it was not.
        view_rms_px: root mean square residual of each used picture.
    """

    lens: Lens
    principal_point_sigma_px: tuple[float, float]
    noise_px: float
    used: tuple[Path, ...]
    unused: tuple[Path, ...]
    view_rms_px: tuple[float, ...]


def calibrate_chessboard(
    folder: Path, board: str, square_mm: float = 1.0, emit: Emit = silent
) -> ChessboardCalibration:
    """Calibrate from all pictures of a folder.

    Args:
        folder: pictures of one board, taken with one camera and focus, from different sides.
        board: inner corners, ``"9x6"``.
        square_mm: side of a square; the lens does not depend on it.
        emit: progress, one step a picture.

    Raises:
        StageError: no pictures, pictures of different size, no board in any, too few views, or views that do
            not determine the lens.
    """
    columns, rows = _board_size(board)
    if not 0 < square_mm < inf:
        raise StageError("lens", f"a square of {square_mm:g} mm is none", "give --square-mm above zero")
    files = sorted((f for f in _listed(folder) if f.suffix.lower() in ENDINGS), key=natural_key)
    if not files:
        raise StageError("lens", f"{folder} has no pictures", f"put pictures there ({', '.join(ENDINGS)})")
    views, unused, size = [], [], (0, 0)
    for done, file in enumerate(files):
        emit(Event(stage="lens", done=done, total=len(files), message=file.name))
        grey = _read(file)
        if size not in ((0, 0), grey.shape):
            raise StageError(
                "lens",
                f"{file} has {grey.shape[1]} x {grey.shape[0]} pixels, "
                f"{files[0].name} has {size[1]} x {size[0]}",
                "give pictures of one camera only",
            )
        size = (grey.shape[0], grey.shape[1])
        corners = find_corners(grey, columns, rows)
        if corners is None:
            unused.append(file)
        else:
            views.append(BoardView(file=file, corners_px=corners))
    emit(Event(stage="lens", done=len(files), total=len(files)))
    if not views:
        raise StageError(
            "lens", f"no picture in {folder} shows a board of {board} inner corners", "check the board's size"
        )
    return calibrate_views(views, _board_points(columns, rows, square_mm), size[1], size[0], tuple(unused))


def find_corners(grey: Array, columns: int, rows: int) -> Array | None:
    """Corners (columns * rows, 2) of the board in a grey uint8 picture, our origin; None if not found."""
    found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=cv2.CALIB_CB_ACCURACY)
    if not found:
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
        found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=flags)
    # OpenCV counts from the first pixel's centre, we from its corner
    return np.asarray(corners, dtype=float).reshape(-1, 2) + 0.5 if found else None


def calibrate_views(
    views: Sequence[BoardView],
    points_on_board: Array,
    width_px: int,
    height_px: int,
    unused: tuple[Path, ...] = (),
) -> ChessboardCalibration:
    """Adjust lens and poses to the corners; see :func:`calibrate_chessboard`."""
    if len(views) < FEWEST_VIEWS:
        raise StageError(
            "lens",
            f"only {len(views)} of {len(views) + len(unused)} pictures show the whole board",
            f"take at least {FEWEST_VIEWS}, better 10, from different sides",
        )
    corners = np.array([view.corners_px for view in views])
    model = BoardModel(
        corners_px=corners, board=points_on_board, half_diagonal_px=hypot(width_px, height_px) / 2
    )
    found = solve(
        "lens",
        model.residuals,
        model.start(width_px, height_px),
        weights=np.ones(2 * len(points_on_board) * len(views)),
        options=FitOptions(loss=Loss.HUBER, iterations=100),
        update=model.update,
    )
    sigmas = np.sqrt(np.diag(found.covariance)[:4])
    squares = (found.residuals.reshape(len(views), -1) ** 2).mean(axis=1)
    return ChessboardCalibration(
        lens=_lens(found.values, sigmas, width_px, height_px),
        principal_point_sigma_px=(float(sigmas[1]), float(sigmas[2])),
        noise_px=found.noise_sigma,
        used=tuple(view.file for view in views),
        unused=unused,
        view_rms_px=tuple(float(value) for value in np.sqrt(squares)),
    )


def _lens(values: Array, sigmas: Array, width_px: int, height_px: int) -> Lens:
    """The lens from the first unknowns: focal length, principal point, lambda; and their sigmas (4,)."""
    focal, cx, cy, division_lambda = (float(value) for value in values[:4])
    if sigmas[0] > 0.2 * abs(focal) or focal <= 0:
        raise StageError(
            "lens", "the pictures do not determine the focal length", "tilt the board by 30 degrees in some"
        )
    return Lens(
        width_px=width_px,
        height_px=height_px,
        focal_px=focal,
        principal_point_px=(cx, cy),
        division_lambda=division_lambda,
        lambda_radius=LambdaRadius.HALF_DIAGONAL,
        focal_sigma_px=float(sigmas[0]),
        lambda_sigma=float(sigmas[3]),
    )


def survey_lines(found: ChessboardCalibration) -> str:
    """What to write under ``[block.lens]`` of survey.toml, with the standard deviations as remarks."""
    lens, (sx, sy) = found.lens, found.principal_point_sigma_px
    x, y = lens.principal_point_px
    lines = [
        "[block.lens]",
        f"focal_px = {lens.focal_px:.3f}  # standard deviation {lens.focal_sigma_px:.3f}",
        f"principal_point_px = [{x:.3f}, {y:.3f}]  # standard deviation {sx:.3f}, {sy:.3f}",
        f"division_lambda = {lens.division_lambda:.6f}  # standard deviation {lens.lambda_sigma:.6f}",
        f'lambda_radius = "{lens.lambda_radius}"',
        "calibrated = true",
        f"# {len(found.used)} pictures used, {len(found.unused)} without the board, "
        f"corners to {found.noise_px:.3f} px, images of {lens.width_px} x {lens.height_px} px",
    ]
    return "\n".join(lines)


def _board_points(columns: int, rows: int, square: float) -> Array:
    """(n, 3) corners on the board, z = 0, row by row as OpenCV gives them, about the board's middle."""
    x, y = np.meshgrid(np.arange(columns) - (columns - 1) / 2, np.arange(rows) - (rows - 1) / 2)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]) * square


def _board_size(board: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)\s*[xX×]\s*(\d+)", board.strip())
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if min(size) < 3:
        raise StageError(
            "lens", f'"{board}" is no size of a chessboard', "give its inner corners, at least 3x3, like 9x6"
        )
    return size


def _listed(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise StageError("lens", f"{folder} is no folder", "give the folder with the pictures")
    return [file for file in folder.iterdir() if file.is_file()]


def _read(file: Path) -> Array:
    data = np.frombuffer(file.read_bytes(), np.uint8)
    grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if data.size else None
    if grey is None:
        raise StageError("lens", f"{file} cannot be read as an image", "restore it or take it out")
    return np.asarray(grey)
