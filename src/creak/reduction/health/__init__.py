"""Can a superelement be trusted? Rigid body, grounding, frequencies, mass and an estimate of the error."""

from creak.reduction.health.report import Health, health, health_rows

__all__ = ["Health", "health", "health_rows"]
