"""Experiments, by the names that the command line has for them; the module of one is imported when it is run."""

from importlib import import_module
from typing import Final

from mmt_drake.diagrams.proof.studies import Study

MODULES: Final = {
    "1": "report",
    "2": "second",
    "3": "report",
    "engines": "engines.report",
    "ablation": "ablation.report",
    "objects": "objects",
    "adequacy": "adequacy",
    "late": "late",
    "coverage": "coverage",
    "passivity": "passivity",
    "cloud": "cloud_report",
    "fit": "first_models",
    "device": "device",
    "learning": "learning",
    "carrying": "carrying",
    "scene": "scene",
    "arms": "arms.report",
    "arm-force": "arms.probe",
    **dict.fromkeys(("estimators", "plants", "network", "updates", "peers", "bands", "surfaces"), "comparisons"),
}
"""Name -> the module here that has it among its `STUDIES`."""


def study_of(name: str) -> Study:
    """The study of this name, one of `MODULES`."""
    studies: dict[str, Study] = import_module(f"{__name__}.{MODULES[name]}").STUDIES
    return studies[name]
