"""Whether two shaders compute the same: interpreted on the same inputs, with noise.

    from shaderlab.analysis.equivalence.comparison import Plan, compare_programs

    answer = compare_programs(load(old), load(new), Plan(ranges={"distance": "0..50"}))
    answer.same                                             # True, False, or None: can't say
    "\\n".join(answer.lines())

Both run in float64, once as they are and several times with noise that is a little larger than
any rounding. An output is another one where the two are further apart than 16 times the spread
that noise makes at that invocation, or where only one of them draws, or is defined.
"""
