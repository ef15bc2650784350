"""Real arms, each diagnosed on one log and held to another, and what that is worth in set-up 3."""

from mmt_drake.diagrams.proof.experiments.arms import probe, report

STUDIES = {**report.STUDIES, **probe.STUDIES}

__all__ = ["STUDIES"]
