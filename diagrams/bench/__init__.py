"""The figures of `mmt-drake bench`, measured here and now, each with its target and, where there is one, a peer."""

from collections.abc import Iterator

from diagrams.bench.measurement import Measurement

__all__ = ["Measurement", "measurements"]


def measurements() -> Iterator[Measurement]:
    """Every figure, as it comes."""
    # Imported late: the first figure should not wait for what the last one needs.
    from diagrams.bench import accuracy, kernels, repeatability, setup

    for part in (setup, kernels, accuracy, repeatability):
        yield from part.measurements()
