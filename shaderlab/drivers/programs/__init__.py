"""What a draw needs before any device: its program compiled, its data fitted, its layouts known.

Every backend builds on this room; nothing in it touches a graphics API.
"""
