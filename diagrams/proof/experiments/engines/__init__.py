"""The thesis's engine table (appendix E): the renderer and other people's physics engines against the exact H(s).

One file per engine says how it is used. MuJoCo, Bullet and DART are the optional extra `engines`, imported only when
they are run.
"""

from mmt_drake.diagrams.proof.experiments.engines.report import engines_table, findings, report_of, thesis_table
from mmt_drake.diagrams.proof.experiments.engines.run import EnginesResult, run_engines, runs_of

__all__ = ["EnginesResult", "engines_table", "findings", "report_of", "run_engines", "runs_of", "thesis_table"]
