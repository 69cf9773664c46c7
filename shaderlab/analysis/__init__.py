"""What a shader computes, without a device: an interpreter, and what is built on it."""
