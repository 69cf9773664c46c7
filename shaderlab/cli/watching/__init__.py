"""Watching: files that are saved, and what depends on them, judged again by warm workers."""
