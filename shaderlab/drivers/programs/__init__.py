"""What a draw needs before any device: its program compiled, its data fitted, its layouts known.

Every driver builds on this package; nothing in it touches a graphics API.
"""
