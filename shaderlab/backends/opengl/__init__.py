"""OpenGL on EGL, without a screen."""
