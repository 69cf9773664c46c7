"""From a scene to its record: the only room that knows all the others below it."""

from shaderlab.pipeline.lab import Lab, Options

__all__ = ["Lab", "Options"]
