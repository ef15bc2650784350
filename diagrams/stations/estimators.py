"""The telerobot's estimators: the options that choose them, their names and their systems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from pydrake.systems.framework import System

from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.rls_estimator import RlsEstimator

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

EstimatorOptions = RlsOptions | OutputErrorOptions
NAMES: Final[Mapping[type, str]] = {RlsOptions: "rls", OutputErrorOptions: "output_error"}
"""What an estimator is called, in results and on the command line; see `mmt_drake.cli.experiment`."""

_SYSTEMS: Final[Mapping[type, Callable[[Any, Site], System]]] = {
    RlsOptions: lambda options, _: RlsEstimator(options),
    OutputErrorOptions: lambda options, site: OutputErrorEstimator(options, worker=site.worker),
}


def estimator(site: Site) -> System:
    """The estimator that the scenario asks for."""
    chosen = replace(site.scenario.estimator, step=site.step)
    return _SYSTEMS[type(chosen)](chosen, site)
