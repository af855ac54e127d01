"""The one error that a person can act on."""


class StageError(Exception):
    """Input that cannot be worked with, told in one sentence: who found it, what is wrong, what to do.

    Args:
        stage: name of the stage that found it, e.g. ``"frames"``.
        cause: what is wrong, naming the file, key or frame.
        remedy: what the person can do about it, in the imperative.
    """

    def __init__(self, stage: str, cause: str, remedy: str) -> None:
        super().__init__(f"{stage}: {cause}; {remedy}.")
        self.stage = stage
        self.cause = cause
        self.remedy = remedy


class Cancelled(Exception):  # noqa: N818 - not an error: the person asked for it
    """Raised out of ``emit`` when the person has asked to stop."""
