"""The report of a steel survey: what ``pipeline.report`` is for a cable, with the same words, page and style.

:func:`write_steel_run` is the door, :func:`summary` what the screen shows.  ``collect`` turns the run into
the records of ``records``, and nothing after it knows a stage.
"""

from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.screen import summary
from pipeline.report.steel.written import write_steel_run

__all__ = ["SteelReport", "summary", "write_steel_run"]
