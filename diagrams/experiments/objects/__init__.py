"""A hundred objects drawn at random: how near the rendered force comes to each one's own."""

from mmt_drake.diagrams.experiments.objects.report import objects_findings, objects_table, report_of
from mmt_drake.diagrams.experiments.objects.run import (
    RANGES,
    ObjectCase,
    ObjectsResult,
    drawn,
    run_model,
    run_object,
    run_objects,
)

__all__ = [
    "RANGES",
    "ObjectCase",
    "ObjectsResult",
    "drawn",
    "objects_findings",
    "objects_table",
    "report_of",
    "run_model",
    "run_object",
    "run_objects",
]
