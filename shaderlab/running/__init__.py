"""Running many scenes: each in a process that it may take down, each record kept at once."""

from shaderlab.running.crew import Crew, Solo, Team
from shaderlab.running.jobs import Job, Limits, Setup

__all__ = ["Crew", "Job", "Limits", "Setup", "Solo", "Team"]
