"""Contact detection on a measured cloud: the experiment the thesis planned and did not make, in simulation."""

from mmt_drake.diagrams.experiments.cloud.findings import cloud_findings
from mmt_drake.diagrams.experiments.cloud.plan import Plan, plan_of
from mmt_drake.diagrams.experiments.cloud.report import cloud_table, report_of
from mmt_drake.diagrams.experiments.cloud.run import Case, Result, cases_of, run_cloud

__all__ = ["Case", "Plan", "Result", "cases_of", "cloud_findings", "cloud_table", "plan_of", "report_of", "run_cloud"]
