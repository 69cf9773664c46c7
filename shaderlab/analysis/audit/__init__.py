"""What may go wrong in a shader, found without a reference: interpreted on searched inputs.

    audit = audit_program(load(source), Plan(ranges={"distance": "0..50"}))
    audit.clean                                             # no hazard was shown
    "\\n".join(audit.lines())

A hazard is shown by an invocation: in float32 an instruction's operands are ones for which GLSL
defines no result there, and an output depends on what the instruction gives.
"""

from .auditing import Plan as Plan, audit_program as audit_program, spread as spread
from .hazard import Audit as Audit, Hazard as Hazard
from .portability import Spread as Spread
