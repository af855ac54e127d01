"""Deflection of a run against the true one: of the nodes below the plane through the supported ones.

A node is where its rods meet; its ball may be eccentric.  The truth is put to the same plane: that of least
squares through the true places of the same supports, where they lie along one line the line.  The limit is
the run's own.
"""

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import most, pairs_by_place, places_of, rms, sigma_check
from pipeline.evaluate.steel.structure_errors import DeflectionErrors

REACH_M = 0.1
_ONE_LINE = 0.02
"""Supports whose spread across is less than this share of the one along lie on one line."""


def compare_deflection(report: Document, truth: Document) -> DeflectionErrors:
    """Compare every node that the run tells a deflection of and the truth knows."""
    told = report.inside("deflection")
    rows, nodes = list(told.items("rows")), list(truth.items("nodes"))
    meeting = places_of(nodes, "rods_m")
    pairs = pairs_by_place(places_of(rows, "position_m"), meeting, REACH_M)
    matched = sorted(pairs)
    found = np.array([rows[n].number("deflection_mm") for n in matched])
    places = meeting[[pairs[n] for n in matched]].reshape(-1, 3)
    held = np.array([rows[n].values.get("support") is True for n in matched], dtype=bool)
    true = 1000 * _below(places, places[held] if held.sum() >= 2 else places)
    free = np.flatnonzero(~held).tolist()
    limit = told.number_or_nan("limit_mm")
    return DeflectionErrors(
        nodes=len(matched),
        rms_mm=rms((found - true).tolist()),
        largest_mm=most((found - true).tolist()),
        found_mm=told.number_or_nan("largest_mm"),
        true_mm=max(true.tolist(), default=float("nan")),
        verdict_right=(told.values.get("over_limit") is True) == bool(len(true) and true.max() > limit),
        sigma=sigma_check(
            (float(found[n] - true[n]) for n in free),
            (rows[matched[n]].number_or_nan("sigma_mm") for n in free),
        ),
    )


def _below(places: Array, supports: Array) -> Array:
    """(n,) metres by which places (n, 3) lie below the plane z = a + b x + c y through the supports."""
    middle = supports.mean(axis=0)
    flat = (supports - middle)[:, :2]
    _, spread, axes = np.linalg.svd(flat, full_matrices=False)
    kept = axes[:1] if len(supports) < 3 or spread[1] < _ONE_LINE * spread[0] else axes
    design = np.column_stack([np.ones(len(flat)), flat @ kept.T])
    plane = np.linalg.lstsq(design, supports[:, 2] - middle[2], rcond=None)[0]
    local = np.column_stack([np.ones(len(places)), (places - middle)[:, :2] @ kept.T])
    return np.asarray(local @ plane - (places[:, 2] - middle[2]))
