"""Devices: drivers, one folder each, what stands before every one of them (`safety`), and what joins two machines."""

from pathlib import Path

from mmt_drake.kernel_cache import discard_stale

discard_stale(Path(__file__).parent)  # constants of safety and driver are compiled into their kernels
