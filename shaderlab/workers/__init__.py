"""Worker processes: a callable runs in a process with a deadline and a memory limit.

Nothing here knows of the lab.
"""
