"""Real arms, each diagnosed on one log and held to another: `experiment arms`."""

from mmt_drake.diagrams.proof.experiments.arms.report import STUDIES

__all__ = ["STUDIES"]
