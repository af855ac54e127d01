"""The photos of a run, once fused with the scans, against the true ones: how much too large their model is.

Takes report.json's ``fusion.photos`` (where each camera stood, site frame) and the true ones, matched
by the picture's name without its ending.  The scale is that of the spread of the cameras about their middle.
"""

from pathlib import PurePath

import numpy as np

from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import most, places_of, rigid_fit, rms
from pipeline.evaluate.steel.records import FusionErrors

LEAST = 3
"""Fewer cameras have no spread worth comparing."""


def compare_fusion(report: Document, truth: Document) -> FusionErrors | None:
    """Compare the cameras; None where run or truth has too few of them."""
    fusion = report.inside("fusion")
    if "photos" not in fusion or "photos" not in truth:
        return None
    true = {
        PurePath(row.text("name")).stem: -row.array("rotation", 3, 3).T @ row.array("translation", 3)
        for row in truth.items("photos")
    }
    rows = [row for row in fusion.items("photos") if PurePath(row.text("name")).stem in true]
    if len(rows) < LEAST:
        return None
    found = places_of(rows, "position_m")
    wanted = np.array([true[PurePath(row.text("name")).stem] for row in rows])
    spread = np.linalg.norm(found - found.mean(axis=0)), np.linalg.norm(wanted - wanted.mean(axis=0))
    turn, shift = rigid_fit(found, wanted)
    away = np.linalg.norm(found - wanted, axis=1)
    return FusionErrors(
        photos=len(rows),
        true_photos=len(true),
        scale_percent=100 * (float(spread[0] / spread[1]) - 1),
        rms_mm=1000 * rms(away.tolist()),
        largest_mm=1000 * most(away.tolist()),
        fitted_rms_mm=1000 * rms(np.linalg.norm(found @ turn.T + shift - wanted, axis=1).tolist()),
        median_mm=fusion.number_or_nan("median_mm"),
    )
