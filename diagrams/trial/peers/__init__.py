"""Other people's identification packages on the trial's files: how long they take, and what they say.

`compare` gives one case to mujoco.sysid, to pysindy and to the project's own fit. The packages are the optional extra
`peers`, imported only when they are called.
"""

from mmt_drake.diagrams.trial.peers.compare import compare
from mmt_drake.diagrams.trial.peers.extra import missing_extra
from mmt_drake.diagrams.trial.peers.result import (
    Estimate,
    PeerResult,
    fits_tables,
    missing_lines,
    speed_lines,
    speed_ratios,
)

__all__ = [
    "Estimate",
    "PeerResult",
    "compare",
    "fits_tables",
    "missing_extra",
    "missing_lines",
    "speed_lines",
    "speed_ratios",
]
