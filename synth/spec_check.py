"""What the values of a specification must not be together; knows the records, not the file."""

import itertools
import math
from typing import NoReturn

import numpy as np

from pipeline.core.errors import StageError
from synth.lens import max_distorted_radius
from synth.spec import Spec
from synth.surface import axis_m, base_radius_m, largest_radius_m

STAGE = "spec"


def refuse(key: str, problem: str, remedy: str) -> NoReturn:
    """Raise the StageError of a key that cannot be as it is."""
    raise StageError(STAGE, f"{key} {problem}", remedy)


def check_together(spec: Spec) -> None:
    """Refuse what only a look at several keys can refuse.

    Raises:
        StageError: naming the key that does not go with the others.
    """
    _check_stations(spec)
    _check_fillet(spec)
    _check_defects(spec)
    _check_lost(spec)
    reach_m = largest_radius_m(spec.cable) + 0.02 + _widest_bow_m(spec)
    if spec.robot.standoff_m < reach_m:
        refuse("robot.standoff_m", f"is {spec.robot.standoff_m} m", f"give at least {reach_m:.3f} m")
    if len({angle % 360.0 for angle in spec.angles_deg}) < len(spec.angles_deg):
        refuse("robot.angles_deg", "names the same place twice", "give every camera its own azimuth")
    for i, frame in enumerate(spec.depth_frames):
        if not 0 <= frame < spec.robot.frames:
            refuse(f"depth_frames[{i}]", f"is {frame}", f"give a frame from 0 to {spec.robot.frames - 1}")
    if spec.sensor.output == "video" and (spec.lens.width_px % 2 or spec.lens.height_px % 2):
        refuse("lens.width_px, lens.height_px", "are odd", "a video needs even numbers")
    if max_distorted_radius(spec.lens) is None:
        refuse(
            "lens.division_lambda",
            f"is {spec.lens.division_lambda}, which folds the image within the frame",
            "give a smaller one",
        )


def _check_stations(spec: Spec) -> None:
    stations = spec.cable.station
    names = [station.name for station in stations]
    if len(set(names)) < len(names):
        refuse("cable.station", f"has a name twice among {names}", "give every station its own name")
    positions = [station.position_m for station in stations]
    if any(b <= a for a, b in itertools.pairwise(positions)):
        refuse("cable.station", f"is not in order: positions {positions}", "sort by position_m")
    for i, station in enumerate(stations):
        if not 0 <= station.position_m <= spec.robot.travel_m:
            refuse(
                f"cable.station[{i}].position_m",
                f"is {station.position_m} m",
                f"give a place on the travel, 0 to {spec.robot.travel_m} m",
            )
    given = [station.diameter_mm is not None for station in stations]
    if any(given) and not all(given):
        refuse("cable.station.diameter_mm", "is given for some stations", "give it for all or for none")


def _check_fillet(spec: Spec) -> None:
    fillet = spec.cable.fillet
    if fillet is not None and fillet.width_mm >= math.pi * spec.cable.diameter_mm / 4:
        refuse("cable.fillet.width_mm", f"is {fillet.width_mm} mm", "keep it below a quarter of the girth")


def _check_defects(spec: Spec) -> None:
    girth_mm = 2000.0 * math.pi * base_radius_m(spec.cable)
    if spec.cable.defect and spec.cable.fillet is not None:
        refuse("cable.defect", "does not go with cable.fillet", "leave one of them out")
    for i, defect in enumerate(spec.cable.defect):
        key = f"cable.defect[{i}]"
        if not 0 <= defect.position_m <= spec.robot.travel_m:
            remedy = f"give a place on the travel, 0 to {spec.robot.travel_m} m"
            refuse(f"{key}.position_m", f"is {defect.position_m} m", remedy)
        if defect.width_mm > girth_mm / 2.0:
            refuse(f"{key}.width_mm", f"is {defect.width_mm} mm", "keep it below half of the girth")
        if defect.height_mm > min(defect.width_mm, defect.length_mm) / 4.0:
            remedy = "keep it below a quarter of width_mm and length_mm"
            refuse(f"{key}.height_mm", f"is {defect.height_mm} mm", remedy)


def _widest_bow_m(spec: Spec) -> float:
    ends = np.array([-spec.cable.margin_m, spec.robot.travel_m / 2.0])
    return float(np.hypot(*axis_m(spec.cable, spec.robot.travel_m, ends)).max())


def _check_lost(spec: Spec) -> None:
    lost = spec.survey.lost_blocks
    for i, block in enumerate(lost):
        if block not in spec.blocks:
            refuse(f"survey.lost_blocks[{i}]", f"is {block!r}", f"name one of {', '.join(spec.blocks)}")
    if set(lost) == set(spec.blocks):
        refuse("survey.lost_blocks", "leaves no block", "keep at least one")
