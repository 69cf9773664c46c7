"""Records as something to read: the HTML page, and the formats of `shaderlab.report.formats`.

This room sees records, errors and pictures only: never a case, a shader or a device. Jinja is
loaded with `html`; Pygments, latex2mathml and cattrs are when a function needs them.
"""
