"""Geometric, robust fits: line, circle, ellipse, cylinder, sphere, similarity.

Every fit minimises distances from the points to the figure (never an algebraic error, which makes a circle
through a noisy arc too small), weights gross errors down, and returns a frozen record with its covariance.
Lengths come out in the unit of the points.
"""

from pipeline.core.fits.circle import Circle, CirclePrior, fit_circle
from pipeline.core.fits.cylinder import Cylinder, fit_cylinder
from pipeline.core.fits.ellipse import Ellipse, fit_ellipse
from pipeline.core.fits.line import Line2D, fit_line
from pipeline.core.fits.robust import FitOptions, Loss
from pipeline.core.fits.similarity import Similarity, fit_similarity
from pipeline.core.fits.sphere import Sphere, fit_sphere

__all__ = [
    "Circle",
    "CirclePrior",
    "Cylinder",
    "Ellipse",
    "FitOptions",
    "Line2D",
    "Loss",
    "Similarity",
    "Sphere",
    "fit_circle",
    "fit_cylinder",
    "fit_ellipse",
    "fit_line",
    "fit_similarity",
    "fit_sphere",
]
