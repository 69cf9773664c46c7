"""Judging frames: pure NumPy, no device."""

from shaderlab.checks.judge import judge
from shaderlab.checks.judgement import Judgement
from shaderlab.checks.measured import outputs_read
from shaderlab.checks.naming import draw_key, reference_for, split_output

__all__ = ["Judgement", "draw_key", "judge", "outputs_read", "reference_for", "split_output"]
