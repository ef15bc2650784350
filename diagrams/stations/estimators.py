"""The telerobot's estimators by the options that choose them: names, systems, and the same without a diagram."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import System

from mmt_drake.diagrams.stations.own_parts import OwnPart
from mmt_drake.estimation.offline import estimate
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.trace import EstimatorTrace
from mmt_drake.model.parameters import THETA, InPlane
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Time
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.rls_estimator import RlsEstimator

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site


@dataclass(frozen=True)
class OwnEstimator(OwnPart):
    """An estimator of a person's own.

    Attributes:
        step: sample time [s].
    """

    step: Time = 0.001
    PART = "estimator"
    NEEDED = ("theta", "stable")
    tells: ClassVar[tuple[str, ...]] = ()
    in_plane: ClassVar[InPlane] = "per_axis"


EstimatorOptions = RlsOptions | OutputErrorOptions | OwnEstimator


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


def replayed(measurement: Array, in_contact: Array, own: OwnEstimator) -> EstimatorTrace:
    """One's own estimator over a measurement (n, 9) and contact (n,), every `own.step` [s].

    Forces that it does not tell are NaN, as theta is until it is known.

    Raises:
        BadInput: as `OwnPart.made`.
    """
    system = own.made(own.step)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    sizes = {"theta": len(THETA), "stable": 1, "estimated_force": 3, "filtered_force": 3}
    found = {name: np.full((len(in_contact), size), np.nan) for name, size in sizes.items()}
    given = {"measurement": measurement, "in_contact": in_contact[:, None]}
    inputs = [(system.GetInputPort(name), rows) for name, rows in given.items() if system.HasInputPort(name)]
    outputs = [(system.GetOutputPort(name), rows) for name, rows in found.items() if system.HasOutputPort(name)]
    for k in range(len(in_contact)):
        for port, rows in inputs:
            port.FixValue(context, rows[k])
        simulator.AdvanceTo((k + 1) * own.step)
        for port, rows in outputs:
            rows[k] = port.Eval(context)
    return EstimatorTrace(**{**found, "stable": found["stable"][:, 0]})


def _free_running(options: OutputErrorOptions, site: Site) -> OutputErrorEstimator:
    """Of the surface it believes what touches do, unless it is told."""
    touch = site.scenario.touch
    if options.surface is None and touch is not None:
        options = replace(options, surface=touch.deviation)
    return OutputErrorEstimator(options, worker=site.worker or site.spread, waits=site.spread)


KINDS: Final[Mapping[type, EstimatorKind]] = {
    RlsOptions: EstimatorKind("rls", lambda options, _: RlsEstimator(options), estimate),
    OutputErrorOptions: EstimatorKind("output_error", _free_running, estimate_output_error),
    OwnEstimator: EstimatorKind("own", lambda options, site: options.made(site.step), replayed),
}


def estimator_name(options: EstimatorOptions) -> str:
    """The name of an estimator in results: of its kind, or of one's own class."""
    return options.called if isinstance(options, OwnEstimator) else KINDS[type(options)].name


def estimator(site: Site) -> System:
    """The estimator that the scenario asks for."""
    chosen = replace(site.scenario.estimator, step=site.step)
    return KINDS[type(chosen)].system(chosen, site)
