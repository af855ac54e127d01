"""What the values of a specification must not be together; knows the records, not the file."""

import itertools
import math
from typing import NoReturn

from pipeline.core.errors import StageError
from synth.lens import max_distorted_radius
from synth.spec import Spec
from synth.surface import largest_radius_m

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
    reach_m = largest_radius_m(spec.cable) + 0.02
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
