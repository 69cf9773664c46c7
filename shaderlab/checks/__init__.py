"""Judging frames: pure NumPy, no device."""

from shaderlab.checks.judge import draw_key, judge, reference_for, split_output
from shaderlab.checks.judgement import Judgement

__all__ = ["Judgement", "draw_key", "judge", "reference_for", "split_output"]
