"""What a shader computes, without a device: an interpreter, and what is built on it."""

CHECKING_WORK = "shaderlab.analysis.self_check:CheckingWorker"
"""What workers that run cases call, as of `shaderlab.engine.jobs.ProcessExecutor`."""
