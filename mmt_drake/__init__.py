"""Model-mediated teleoperation on Drake."""

__version__ = "0.1.0"
