"""What must hold of a scene: one kind of expectation a file.

A new kind is a new file here and a line here; kinds that live elsewhere, in a user's own
package, work like these: whatever derives from `Expectation` can be in a case's `expect`.
"""

from shaderlab.expectations.any_order import any_order, both_ways
from shaderlab.expectations.attribute_layout import AttributeLayout, attribute_layout
from shaderlab.expectations.block_layout import BlockLayout, block_layout
from shaderlab.expectations.bounded import Bounded, bounded
from shaderlab.expectations.compile_fails import CompileFails, compile_fails
from shaderlab.expectations.computed import Computed, computed
from shaderlab.expectations.cost import Cost, cost
from shaderlab.expectations.coverage import Coverage, coverage
from shaderlab.expectations.energy_conserving import EnergyConserving, energy_conserving
from shaderlab.expectations.exact import Exact, exact
from shaderlab.expectations.formula import Formula, formula
from shaderlab.expectations.gl_call import GlCall, gl_call
from shaderlab.expectations.gl_error import GlError, gl_error
from shaderlab.expectations.inactive_uniforms import InactiveUniforms, inactive_uniforms
from shaderlab.expectations.mean_of import MeanOf, mean_of
from shaderlab.expectations.measure import Measure, Reading, measure, reading
from shaderlab.expectations.monotone import Monotone, monotone
from shaderlab.expectations.query import Query, query
from shaderlab.expectations.refused import Refused, refused
from shaderlab.expectations.sweep import Sweep, sweep
from shaderlab.expectations.symmetric import Symmetric, symmetric
from shaderlab.expectations.value import Value, value
from shaderlab.model import Expectation

__all__ = [
    "AttributeLayout",
    "BlockLayout",
    "Bounded",
    "CompileFails",
    "Computed",
    "Cost",
    "Coverage",
    "EnergyConserving",
    "Exact",
    "Expectation",
    "Formula",
    "GlCall",
    "GlError",
    "InactiveUniforms",
    "MeanOf",
    "Measure",
    "Monotone",
    "Query",
    "Reading",
    "Refused",
    "Sweep",
    "Symmetric",
    "Value",
    "any_order",
    "attribute_layout",
    "block_layout",
    "both_ways",
    "bounded",
    "compile_fails",
    "computed",
    "cost",
    "coverage",
    "energy_conserving",
    "exact",
    "formula",
    "gl_call",
    "gl_error",
    "inactive_uniforms",
    "mean_of",
    "measure",
    "monotone",
    "query",
    "reading",
    "refused",
    "sweep",
    "symmetric",
    "value",
]
