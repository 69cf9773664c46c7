"""What must hold of a scene: one kind of expectation a file.

A new kind is a new file and a line here; kinds that live elsewhere, in a user's own
package, work like these: whatever derives from `Expectation` can be in a case's `expect`.
"""

from shaderlab.expectations.any_order import any_order as any_order, both_ways as both_ways
from shaderlab.expectations.attribute_layout import (
    AttributeLayout as AttributeLayout,
    attribute_layout as attribute_layout,
)
from shaderlab.expectations.block_layout import (
    BlockLayout as BlockLayout,
    block_layout as block_layout,
)
from shaderlab.expectations.bounded import Bounded as Bounded, bounded as bounded
from shaderlab.expectations.compile_fails import (
    CompileFails as CompileFails,
    compile_fails as compile_fails,
)
from shaderlab.expectations.computed import Computed as Computed, computed as computed
from shaderlab.expectations.cost import Cost as Cost, cost as cost
from shaderlab.expectations.coverage import Coverage as Coverage, coverage as coverage
from shaderlab.expectations.energy_conserving import (
    EnergyConserving as EnergyConserving,
    energy_conserving as energy_conserving,
)
from shaderlab.expectations.exact import Exact as Exact, exact as exact
from shaderlab.expectations.formula import Formula as Formula, formula as formula
from shaderlab.expectations.gl_call import GlCall as GlCall, gl_call as gl_call
from shaderlab.expectations.gl_error import GlError as GlError, gl_error as gl_error
from shaderlab.expectations.inactive_uniforms import (
    InactiveUniforms as InactiveUniforms,
    inactive_uniforms as inactive_uniforms,
)
from shaderlab.expectations.mean_of import MeanOf as MeanOf, mean_of as mean_of
from shaderlab.expectations.measure import (
    Measure as Measure,
    Reading as Reading,
    measure as measure,
    reading as reading,
)
from shaderlab.expectations.monotone import Monotone as Monotone, monotone as monotone
from shaderlab.expectations.query import Query as Query, query as query
from shaderlab.expectations.refused import Refused as Refused, refused as refused
from shaderlab.expectations.sweep import Sweep as Sweep, sweep as sweep
from shaderlab.expectations.symmetric import Symmetric as Symmetric, symmetric as symmetric
from shaderlab.expectations.value import Value as Value, value as value
from shaderlab.model import Expectation as Expectation
