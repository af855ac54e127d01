"""A finished run against the truth: diameters, cameras, lenses, surface, axis, relief.  Steel: ``steel``.

Takes a run folder and a truth.json (of the synthesizer, or one with the stations alone that a person
measured); gives an :class:`Evaluation`, a table for the screen and a JSON file.  Reads only what the run
wrote for everybody: report.json, radius_map.npz and the sparse models.
"""

from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.files import write_json
from pipeline.evaluate.axis import compare_axis
from pipeline.evaluate.cameras import compare_cameras
from pipeline.evaluate.diameters import compare_diameters
from pipeline.evaluate.documents import read_document
from pipeline.evaluate.lenses import compare_lenses
from pipeline.evaluate.records import Evaluation
from pipeline.evaluate.relief import compare_relief
from pipeline.evaluate.steel import evaluate_steel, is_steel
from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.evaluate.surface import compare_surface
from pipeline.evaluate.table import format_table

__all__ = ["Evaluation", "SteelEvaluation", "evaluate", "format_table", "write_evaluation"]


def evaluate(run_folder: Path, truth_json: Path) -> Evaluation | SteelEvaluation:
    """Evaluate a finished run of either kind; parts that truth or run does not hold stay None.

    Raises:
        StageError: a file is missing, or run and truth do not belong together.
    """
    if not run_folder.is_dir():
        raise StageError("evaluate", f"{run_folder} is no folder", "give the folder that --out named")
    report, truth = read_document(run_folder / "report.json"), read_document(truth_json)
    if is_steel(report):
        return evaluate_steel(report, truth)
    axis = report.inside("axis") if "axis" in report else None
    return Evaluation(
        name=report.text("name"),
        diameters=compare_diameters(report, truth),
        cameras=compare_cameras(run_folder, report, truth) if "poses" in truth else None,
        lenses=compare_lenses(report, truth) if "lenses" in truth else None,
        surface=compare_surface(run_folder, report, truth) if "radius_mm" in truth else None,
        axis=compare_axis(report, truth) if "axis" in truth else None,
        relief=compare_relief(report, truth),
        straightness_mm_per_m=axis.number_or_nan("straightness_mm_per_m") if axis else float("nan"),
    )


def write_evaluation(evaluation: Evaluation | SteelEvaluation, path: Path) -> None:
    """Write the evaluation as JSON, its records and fields by their names; unknown numbers are null.

    Raises:
        StageError: the place cannot be written.
    """
    write_json(path, {"format": 1, **vars(evaluation)}, stage="evaluate")
