"""The figures of `mmt-drake bench`, measured here and now, each with its target and, where there is one, a peer."""

from collections.abc import Iterator
from importlib import import_module

from mmt_drake.diagrams.bench.measurement import Measurement

__all__ = ["GROUPS", "Measurement", "measurements"]

GROUPS = {
    "quick": ("setup", "kernels", "accuracy", "repeatability", "viewer"),
    "diagnosis": ("diagnosis",),
    "pacing": ("pacing",),
    "haptics": ("haptics",),
}
"""Group -> the modules here that measure it."""


def measurements(group: str = "quick", **options: float) -> Iterator[Measurement]:
    """Every figure of one of `GROUPS`, as it comes; options are those of its module."""
    for part in GROUPS[group]:
        # Imported late: the first figure should not wait for what the last one needs.
        yield from import_module(f"mmt_drake.diagrams.bench.{part}").measurements(**options)
