"""The order of the cable pipeline, and no algorithm.

survey -> frames -> each block (lens, pos, match, adjust) -> the ring, where there is one clock (closing,
joint) -> each block (undistort, dense, surface, texture, crop) -> mosaic -> ring -> measure.  Every arrow is
a product in the run folder, wired in ``block_stages.py`` and ``ring_stages.py``;
:mod:`pipeline.core.runfolder` tells what is kept and what is made again.
"""

from pathlib import Path

from pipeline.cable.chain import Chain
from pipeline.cable.records import CableOptions, CableRun
from pipeline.cable.survey import Survey
from pipeline.core.events import Emit
from pipeline.core.options import build, override
from pipeline.core.runfolder import RunFolder

STAGES = (
    "frames",
    "lens",
    "pos",
    "match",
    "adjust",
    "closing",
    "joint",
    "undistort",
    "dense",
    "surface",
    "texture",
    "crop",
    "mosaic",
    "ring",
    "measure",
)


def bind_options(survey: Survey, assignments: tuple[str, ...] = ()) -> CableOptions:
    """The effective options: defaults, then the survey's ``[options]``, then ``--set`` words.

    Raises:
        StageError: an unknown stage or key, or a value that does not fit.
    """
    options = build(CableOptions, dict(survey.options), key="options")
    for assignment in assignments:
        options = override(options, assignment)
    return options


def run_cable(
    survey: Survey,
    options: CableOptions,
    run: RunFolder,
    emit: Emit,
    pairs: Path | None = None,
    last: str = STAGES[-1],
) -> CableRun | None:
    """Run the stages in order, up to ``last``.

    Args:
        survey: what to work on.
        options: of every stage.
        run: where products are kept.
        emit: progress; may raise Cancelled.
        pairs: file of corresponding points chosen by hand, or None to find them.
        last: stop after this stage.

    Returns:
        Everything found, or None where ``last`` comes before the end.

    Raises:
        StageError: bad input, or ``last`` is a stage that this survey does not need.
    """
    chain = Chain(survey, options, run, emit)
    for name in STAGES[: STAGES.index(last) + 1]:
        chain.run(name, pairs)
    chain.require(last)
    return chain.result() if last == STAGES[-1] else None
