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
from pipeline.core.options import build, override

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


def run_cable(chain: Chain, pairs: Path | None = None, last: str = STAGES[-1]) -> CableRun | None:
    """Run the stages that are still to be run, in order, up to ``last``.

    Args:
        chain: of the survey; progress may raise Cancelled.
        pairs: file of corresponding points chosen by hand, or None to find them.
        last: stop after this stage.

    Returns:
        Everything found, or None where ``last`` comes before the end.

    Raises:
        StageError: bad input, or ``last`` is a stage that this survey does not need.
    """
    for name in STAGES[: STAGES.index(last) + 1]:
        if name not in chain.made:
            chain.run(name, pairs)
    chain.require(last)
    return chain.result() if last == STAGES[-1] else None
