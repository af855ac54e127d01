"""The order of the steel pipeline, and no algorithm.

survey -> each station (clouds, targets) -> all stations (register, compare) -> the registered cloud (tiles,
members, measure) -> photos, fuse.  Every arrow is a product in the run folder, wired in
``station_stages.py`` and ``chain.py``; :mod:`pipeline.core.runfolder` tells what is kept and what is made
again.
"""

from pipeline.core.events import Emit
from pipeline.core.runfolder import RunFolder
from pipeline.steel.chain import SteelChain
from pipeline.steel.options import SteelOptions
from pipeline.steel.steel_run import SteelRun
from pipeline.steel.survey_records import SteelSurvey

STEEL_STAGES = ("clouds", "targets", "register", "compare", "tiles", "members", "measure", "photos", "fuse")


def run_steel(
    survey: SteelSurvey, options: SteelOptions, run: RunFolder, emit: Emit, last: str = STEEL_STAGES[-1]
) -> SteelRun | None:
    """Run the stages in order, up to ``last``.

    Args:
        survey: what to work on.
        options: of every stage.
        run: where products are kept.
        emit: progress; may raise Cancelled.
        last: stop after this stage.

    Returns:
        Everything found, or None where ``last`` comes before the end.

    Raises:
        StageError: bad input.
    """
    chain = SteelChain(survey, options, run, emit)
    for name in STEEL_STAGES[: STEEL_STAGES.index(last) + 1]:
        chain.run(name)
    return chain.result() if last == STEEL_STAGES[-1] else None
