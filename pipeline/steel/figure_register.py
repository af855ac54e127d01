"""Registration on targets first, then on targets, axes and planes together.

Takes the survey and every station's features, the targets named; gives the features with their axes and
planes named as well, and the registration on all of them.  Targets place the stations well enough for the
figures to be told apart; with these the stations are known better, and more figures can be.  Figures named by
hand take part from the beginning and keep their names.  Leaves out matching (``figures.py``) and adjusting
(``register.py``).
"""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.core.events import Emit, part
from pipeline.steel.figures import name_figures
from pipeline.steel.records import FeatureKind, StationFeatures
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import Registration
from pipeline.steel.survey_records import SteelSurvey

ROUNDS = 2
"""Matching again with the poses that the first matches gave."""
MOST_DROPS = 3


def register_with_figures(
    survey: SteelSurvey, found: Sequence[StationFeatures], options: RegisterOptions, emit: Emit
) -> tuple[list[StationFeatures], Registration]:
    """Register all stations on their targets and on the axes and planes that they share.

    Raises:
        StageError: as :func:`~pipeline.steel.register.register`.
    """
    features = list(found)
    if not any(f.kind is not FeatureKind.POINT for one in features for f in one.features):
        return features, register(survey, features, options, emit)
    by_hand = {(one.station, f.name, f.kind.value) for one in found for f in one.features if f.name}
    registration = register(survey, features, options, part(emit, 0.0, 0.3))
    for number in range(ROUNDS):
        features = name_figures(found, registration.poses)
        whole = ROUNDS * (MOST_DROPS + 1)
        for drop in range(MOST_DROPS + 1):
            done = number * (MOST_DROPS + 1) + drop
            tell = part(emit, 0.3 + 0.7 * done / whole, 0.3 + 0.7 * (done + 1) / whole)
            registration = register(survey, features, options, tell)
            wrong = _left_out(registration) - by_hand
            if not wrong:
                break
            features = _without(features, wrong)
    return features, registration


def _left_out(registration: Registration) -> set[tuple[str, str, str]]:
    """Station, name and kind of the axes and planes that were left out: gross errors where named by hand,
    else matched by us, and wrongly."""
    return {
        (row.station, row.target, row.kind)
        for row in registration.residuals
        if row.weight == 0 and row.kind != FeatureKind.POINT.value
    }


def _without(features: list[StationFeatures], wrong: set[tuple[str, str, str]]) -> list[StationFeatures]:
    return [
        replace(
            one,
            features=tuple(
                replace(f, name="") if (one.station, f.name, f.kind.value) in wrong else f
                for f in one.features
            ),
        )
        for one in features
    ]
