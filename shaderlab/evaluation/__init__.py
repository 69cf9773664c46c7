"""From a scene to its record: drawn, captured, judged, written down."""

from shaderlab.evaluation.evaluation import Evaluation
from shaderlab.evaluation.lab import Lab

__all__ = ["Evaluation", "Lab"]
