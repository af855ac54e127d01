"""Nodes of a run against the true ones, matched by the place of the ball."""

import math

import numpy as np

from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import most, pairs_by_place, places_of, rms, sigma_check
from pipeline.evaluate.steel.structure_errors import NodeError, NodeErrors

REACH_M = 0.1
LEAST_MM = 1e-3
"""A true eccentricity below this is none."""


def compare_nodes(report: Document, truth: Document) -> NodeErrors:
    """Compare the nodes whose eccentricity the run tells."""
    true = list(truth.items("nodes"))
    found = [row for row in report.items("nodes") if "size_mm" in row]
    pairs = pairs_by_place(
        places_of(true, "ball_m"),
        places_of(found, "ball_m"),
        REACH_M,
    )
    entries = tuple(_entry(true[n], found[m]) for n, m in sorted(pairs.items()))
    loud = [row for row in entries if row.eccentric]
    quiet = [row for row in entries if not row.eccentric]
    false = sum(row.significant for row in quiet)
    return NodeErrors(
        entries=entries,
        true=len(true),
        eccentric=len(loud),
        false=false,
        false_percent=100 * false / len(quiet) if quiet else math.nan,
        missed=sum(not row.significant for row in loud),
        rms_mm=rms(row.error_mm for row in loud),
        largest_mm=most(row.error_mm for row in loud),
        amount_rms_mm=rms(row.amount_error_mm for row in loud),
        amount_largest_mm=most(row.amount_error_mm for row in loud),
        ball_rms_mm=rms(row.ball_mm for row in entries),
        sigma=sigma_check((row.amount_error_mm for row in loud), (row.sigma_mm for row in loud)),
    )


def _entry(true: Document, found: Document) -> NodeError:
    wanted, told = true.array("eccentricity_mm", 3), found.array("eccentricity_mm", 3)
    true_mm, found_mm = float(np.linalg.norm(wanted)), found.number("size_mm")
    away = found.array("ball_m", 3) - true.array("ball_m", 3)
    return NodeError(
        name=true.text("name"),
        found=found.text("name"),
        true_mm=true_mm,
        found_mm=found_mm,
        error_mm=float(np.linalg.norm(told - wanted)),
        amount_error_mm=found_mm - true_mm,
        sigma_mm=found.number_or_nan("sigma_mm"),
        significant=found.values.get("significant") is True,
        eccentric=true_mm > LEAST_MM,
        ball_mm=1000 * float(np.linalg.norm(away)),
    )
