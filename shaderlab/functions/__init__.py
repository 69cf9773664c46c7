"""GLSL functions as Python callables: NumPy in, NumPy out, checked by pytest."""
