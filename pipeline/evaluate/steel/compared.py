"""What every comparison of several things with the truth tells, whatever they are; units in each name.

Differences are result minus truth; rms is the root mean square; a figure that is not known is NaN.
"""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class SigmaCheck:
    """Whether the claimed standard deviations are true.

    Attributes:
        count: values compared.
        within_percent: part of the errors that are at most two sigma.
        over_rms: root mean square of the sigmas over that of the errors: 1 is right, below it too sure.
    """

    count: int
    within_percent: float
    over_rms: float


@dataclass(frozen=True, kw_only=True)
class Compared:
    """The size of the differences, and whether their standard deviations were right.

    Attributes:
        rms_mm, largest_mm: of the differences.
        sigma: claimed against found.
    """

    rms_mm: float
    largest_mm: float
    sigma: SigmaCheck
