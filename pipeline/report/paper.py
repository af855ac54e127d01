"""The figures of the paper, as printed (guo-wenchao-2023, Tables 1 and 2), to stand beside ours."""

from dataclasses import dataclass

IMAGES = 518
CALIBRATED = 493
KEYPOINTS_PER_IMAGE = 413
REPROJECTION_PX = 0.49
COVERAGE_UNITS2 = 3_231_000
RESOLUTION_UNITS = 1.2
DIVISION_LAMBDA = -0.02
MEAN_ABSOLUTE_ERROR_MM = 1.0053


@dataclass(frozen=True, kw_only=True)
class PaperRow:
    """A column of Table 2, as printed."""

    name: str
    model_mm: float
    truth_mm: float
    difference_mm: float
    relative_percent: float


# The printed difference of A contradicts its own row: 112.383 - 111.4 is +0.983.
TABLE_2 = (
    PaperRow(name="A", model_mm=112.383, truth_mm=111.4, difference_mm=-1.017, relative_percent=0.913),
    PaperRow(name="B", model_mm=112.125, truth_mm=110.8, difference_mm=1.325, relative_percent=1.196),
    PaperRow(name="C", model_mm=111.748, truth_mm=110.7, difference_mm=-1.048, relative_percent=0.947),
    PaperRow(name="D", model_mm=111.731, truth_mm=111.1, difference_mm=-0.631, relative_percent=0.568),
)
