"""What every system has in common that learns from checked samples: ports, state, and when it learns."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem, State

from mmt_drake.estimation.output_error.gate import hand_over, initial_readout, settings, take_samples, tick
from mmt_drake.estimation.output_error.learning import K, Learns
from mmt_drake.estimation.output_error.places import PORT_SIZES, STATUS, Settings, Status
from mmt_drake.systems.readout import declare_state_readout

_PATIENCE = 1.0
"""How long learning beside the clock may take before it is told [s]."""


class Learning(Generic[K]):
    """Declares it all in a system, and is there for as long as that.

    Every tick a sample is checked and joins the next sample of the fit; once a period they are learned from. What is
    found from the samples until t is put out `LearningOptions.latency` later, be it computed in an instant or, with a
    worker, beside the clock.

    Args:
        system: gets ports, state and events, and nothing else.
        learner: what it learns with.
        worker: learn in a thread, for a run in real time. What is not done in time is handed over with the next period;
            what fails is left out, and the next samples are tried. The Context then is not all there is, and must not
            be cloned.
    """

    def __init__(self, system: LeafSystem, learner: Learns[K], worker: bool) -> None:
        options = learner.options
        self._settings: Settings = settings(options)
        self._learner = learner
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="estimator") if worker else None
        if self._worker is not None:
            self._worker.submit(
                int
            )  # its thread begins now: in the run it would take the loop's priority and processor
        self._under_way: Future[K] | None = None
        self._begun, self._no_fit = 0.0, False
        known = learner.beginning()
        initial = initial_readout(self._settings, known.theta, known.deviation)
        self._measurement = system.DeclareVectorInputPort("measurement", 9)
        self._in_contact = system.DeclareVectorInputPort("in_contact", 1)
        self._reading = system.DeclareVectorInputPort("reading", 3)
        self._stamp = system.DeclareVectorInputPort("stamp", 1)
        declare_state_readout(system, PORT_SIZES, initial)
        self._knowledge = system.DeclareAbstractState(AbstractValue.Make(known))
        # Half-way between ticks: multiples of two periods that should coincide differ in their last bit now and then.
        first = options.latency - 0.5 * options.step
        system.DeclarePeriodicUnrestrictedUpdateEvent(options.latency, first, self._learn)
        system.DeclarePeriodicDiscreteUpdateEvent(options.step, 0.0, self._update)
        # Compiles before the clock starts.
        tick(np.zeros(9), np.zeros(3), 1.0, 0.0, 0.0, initial.copy(), self._settings)
        learner.compile()

    def _update(self, context: Context, state: DiscreteValues) -> None:
        measurement = self._measurement.Eval(context)
        tick(
            measurement,
            self._reading.Eval(context) if self._reading.HasValue(context) else measurement[6:],
            self._in_contact.Eval(context)[0],
            context.get_time(),
            self._stamp.Eval(context)[0] if self._stamp.HasValue(context) else context.get_time(),
            state.get_mutable_value(),
            self._settings,
        )
        if self._no_fit:
            state.get_mutable_value()[STATUS] = Status.NO_FIT

    def _learn(self, context: Context, state: State) -> None:
        known: K = context.get_abstract_state(self._knowledge).get_value()
        failed = False
        if self._under_way is not None:
            if not self._under_way.done():
                self._no_fit |= context.get_time() - self._begun > _PATIENCE
                return
            self._no_fit = failed = self._under_way.exception() is not None  # whatever it was, the run goes on
            if not failed:
                known = self._under_way.result()
        readout = state.get_mutable_discrete_state().get_mutable_value()
        hand_over(readout, known.theta, known.deviation, known.held)
        samples, broken = take_samples(readout, self._settings)
        broken |= failed  # its samples are gone
        if self._worker is not None:
            self._begun = context.get_time()
            self._under_way = self._worker.submit(self._learner.learned, known, samples, broken)
        else:
            known = self._learner.learned(known, samples, broken)
        state.get_mutable_abstract_state(int(self._knowledge)).set_value(known)
