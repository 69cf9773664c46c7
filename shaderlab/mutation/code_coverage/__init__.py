"""Code coverage: the branches and terms of shaders that no judged pixel exercised

A program is run once more with its expressions wrapped by functions that note what they saw: an
`if` that was never false, a `max` that never chose its second argument, a factor that was 1
everywhere. A mistake there changes no pixel, so that no expectation could notice it.
"""
