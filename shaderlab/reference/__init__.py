"""Formulas by topic: the laws that shaders are judged by, each with its symbols and its source.

A formula takes numbers, float64 arrays or bands alike, and uses nothing but `+ - * /` and
`shaderlab.glslmath`. The last axis of an array holds the components: 1 for a float, 3 for a vec3;
the axis before it, where there is one, runs over pixels or vertices. Parameters are named as the
shaders name their inputs, with `light.constant` written light_constant.
"""
