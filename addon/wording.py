"""The pipeline's sentences in the person's language, as far as they can be.

Takes ``stage: what is wrong; what to do.``; names the stage as the panels do and says which part is the way
out.  The parts themselves stay as the pipeline said them: they name files, keys and numbers.
"""

from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

from .properties.run import STAGES
from .properties.steel import STEEL_STAGES

_FRAME = n_("{stage}: {cause}. What to do: {remedy}")
_LABELS = {name: label for name, label, _ in (*STEEL_STAGES, *STAGES)} | {
    "run": n_("Run"),
    "survey": n_("Survey"),
    "export": n_("Export"),
    "synthesise": n_("Synthesise"),
    "synth": n_("Synthesise"),
    "render": n_("Rendering"),
}
"""Who may have found it, as a person knows it."""


def framed(sentence: str) -> str:
    """The sentence with stage and way out named; unchanged in English, or where it is of another kind."""
    stage, colon, rest = sentence.partition(": ")
    cause, semicolon, remedy = rest.rpartition("; ")
    frame = translated(_FRAME)
    if frame == _FRAME or not (colon and semicolon and stage in _LABELS):
        return sentence
    return frame.format(stage=translated(_LABELS[stage]), cause=cause, remedy=remedy)
