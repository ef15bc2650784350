"""The telerobot's estimators by the options that choose them: names, systems, and the same without a diagram."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pydrake.systems.framework import System

from mmt_drake.estimation.offline import estimate
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.trace import EstimatorTrace
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.rls_estimator import RlsEstimator

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

EstimatorOptions = RlsOptions | OutputErrorOptions


class EstimatorKind(NamedTuple):
    """An estimator that a scenario may have.

    Attributes:
        name: in results and on the command line; see `mmt_drake.cli.experiment`.
        system: makes it.
        replay: the same over a measurement (n, 9) and contact (n,), every `options.step`, without a diagram; their
            options last.
    """

    name: str
    system: Callable[[Any, Site], System]
    replay: Callable[..., EstimatorTrace]


KINDS: Final[Mapping[type, EstimatorKind]] = {
    RlsOptions: EstimatorKind("rls", lambda options, _: RlsEstimator(options), estimate),
    OutputErrorOptions: EstimatorKind(
        "output_error", lambda options, site: OutputErrorEstimator(options, worker=site.worker), estimate_output_error
    ),
}


def estimator(site: Site) -> System:
    """The estimator that the scenario asks for."""
    chosen = replace(site.scenario.estimator, step=site.step)
    return KINDS[type(chosen)].system(chosen, site)
