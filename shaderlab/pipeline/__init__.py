"""From a scene to its record: the only room that knows all the others below it."""

from shaderlab.pipeline.lab import Lab

__all__ = ["Lab"]
