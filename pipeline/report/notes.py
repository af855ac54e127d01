"""What stands under "Please note" at the head of the report.

Takes a :class:`~pipeline.cable.records.CableRun`; gives sentences.
"""

from pipeline.cable.records import CableRun


def notes_of(run: CableRun) -> tuple[str, ...]:
    """What the reader must know before trusting the figures."""
    said = list(run.cautions)
    if run.measurement.unmeasured:
        said.append(
            f"Too little of the surface was seen at {', '.join(run.measurement.unmeasured)}: not measured."
        )
    if not run.options.lens.correct:
        said.append("The lens correction was switched off on purpose: the model is bent.")
    for block in run.blocks:
        if not block.block.lens_spec.calibrated and run.together is None:
            said.append(
                f"The focal length of {block.block.name} is a starting value that the adjustment holds: an "
                "error of 1 % in it changes the diameter by about 0.5 %; calibrate the lens."
            )
        if not block.orientation.calibrated.all():
            missing = int((~block.orientation.calibrated).sum())
            said.append(f"{missing} frames of {block.block.name} could not be calibrated.")
    joined = {n for j in run.mosaic.joins for n in (j.first, j.second)}
    said.extend(
        f"{b.block.name} shares no marks with its neighbours and stands where the POS put it."
        for n, b in enumerate(run.blocks)
        if n not in joined and len(run.blocks) > 1
    )
    return tuple(said)
