"""Keeping a Simulator to the wall clock, and the process out of its own way."""

from mmt_drake.realtime.pace import Pace
from mmt_drake.realtime.pace_report import PaceReport
from mmt_drake.realtime.process import ProcessOptions, real_time_process
from mmt_drake.realtime.runner import advance_paced, warm

__all__ = ["Pace", "PaceReport", "ProcessOptions", "advance_paced", "real_time_process", "warm"]
