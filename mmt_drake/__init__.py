"""Model-mediated teleoperation on Drake."""

from pathlib import Path

from mmt_drake.kernel_cache import discard_stale

__version__ = "0.1.0"

discard_stale(Path(__file__).parent)
