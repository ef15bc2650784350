"""The whole fast path of one hand in one system: for rates at which every evaluation of a port counts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from mmt_drake.closing import Closing
from mmt_drake.hw.safety import kernel
from mmt_drake.hw.safety.limits import SafetyLimits
from mmt_drake.hw.safety.supervisor import check_settings
from mmt_drake.model.held_body import NOT_TOLD
from mmt_drake.model.parameters import THETA
from mmt_drake.rendering import impedance
from mmt_drake.rendering.updates import Policy, renderer_rule
from mmt_drake.systems.readout import declare_parts

Array = NDArray[np.float64]

#: (t [s], motion (6), theta, stable, in_contact, force out (3) [N])
Renderer = Callable[[float, Array, Array, float, float, Array], None]


class Driver(Protocol):
    """A device that is read at the start of a tick and told a force at its end, as `OmegaDriver`."""

    motion: Array
    state: Array

    def read(self) -> None:
        """Bring `motion` (6) and `state` (3) up to date."""

    def send(self, force: Array) -> None:
        """Have the device make a force (3) [N]."""

    def request_forces(self) -> None:
        """Have the motors turned on again."""

    def close(self) -> None:
        """Bring the device to rest."""


def impedance_renderer(period: float = 1e-3, substeps: int = 1, updates: Policy | None = None) -> Renderer:
    """The renderer `ImpedanceReflection` by itself, with a memory of its own.

    Where friction holds the body it is not told.

    Args:
        period, substeps, updates: as `ImpedanceReflection` takes them.

    Raises:
        BadInput: as there.
    """
    rule = renderer_rule(updates, period, substeps)
    out, memory = np.zeros(sum(impedance.READOUT_SIZES)), np.zeros(impedance.MEMORY_SIZE)
    known = memory.view()
    known.flags.writeable = False  # the kernel is compiled for what Drake hands out

    def render(t: float, motion: Array, theta: Array, stable: float, in_contact: float, force: Array) -> None:
        impedance.render(known, t, motion, theta, stable, in_contact, rule, False, NOT_TOLD, out)
        memory[:] = out[-memory.size :]
        force[:] = out[:3]

    render(0.0, np.zeros(6), np.ones(len(THETA)), 0.0, 0.0, np.zeros(3))  # compiles
    memory[:] = 0.0
    return render


class HapticPath(LeafSystem, Closing):
    """Reads the hand, renders, supervises and sends, all in one update; the same kernels as the systems it stands for.

    It does at each tick what `OmegaOperator`, `ImpedanceReflection` and `SafetySupervisor` do wired together, bit for
    bit, at about a third of the cost. What its ports show belongs to the latest tick.

    .. pydrake_system::

        name: HapticPath
        input_ports:
        - theta
        - stable
        - in_contact
        - ages
        - switches
        output_ports:
        - motion
        - force
        - rendered_force
        - status
        - device
        - readout

    Ports (table frame):

    - `theta` (as many as the model has), `stable` (1), `in_contact` (1): as `ImpedanceReflection` takes them.
    - `ages` (one for each of `watched`), `switches` (2): as `SafetySupervisor` takes them.
    - `motion` (6): position [m] and velocity [m/s] of the hand.
    - `force` (3): what the device was told [N].
    - `rendered_force` (3): what the renderer asked for [N].
    - `status` (6), `device` (3): as those of `SafetySupervisor` and the driver.
    - `readout` (21): all of them in this order.

    Args:
        driver: of the device.
        limits: of the supervisor.
        period: of the ticks [s].
        watched: name -> greatest age [s] of the inputs that must stay fresh.
        renderer: what the operator feels.

    Raises:
        BadInput: as `SafetySupervisor`.
    """

    _PARTS = MappingProxyType({"motion": 6, "force": 3, "rendered_force": 3, "status": 6, "device": 3})

    def __init__(
        self,
        driver: Driver,
        limits: SafetyLimits | None = None,
        *,
        period: float = 1e-3,
        watched: Mapping[str, float] = MappingProxyType({}),
        renderer: Renderer | None = None,
    ) -> None:
        super().__init__()
        self.set_name("HapticPath")
        limits = SafetyLimits() if limits is None else limits
        check_settings(limits, period, watched)
        self._driver, self._renderer = driver, impedance_renderer(period) if renderer is None else renderer
        self._limits, self._oldest = limits.kernel_vector(), np.array(list(watched.values()), dtype=np.float64)
        #: Names of the watched inputs, for `describe`.
        self.watched = tuple(watched)
        self._rendered, self._no_ages = np.zeros(3), np.zeros(0)
        # Of two memories one is written while the other is read.
        self._memory, self._next = kernel.initial_memory(), kernel.initial_memory()
        self._theta = self.DeclareVectorInputPort("theta", len(THETA))
        self._stable = self.DeclareVectorInputPort("stable", 1)
        self._contact = self.DeclareVectorInputPort("in_contact", 1)
        self._ages = self.DeclareVectorInputPort("ages", len(watched)) if watched else None
        self._switches = self.DeclareVectorInputPort("switches", 2)
        size = sum(self._PARTS.values())
        state = self.DeclareDiscreteState(size)
        declare_parts(self, self._PARTS, _held, {self.discrete_state_ticket(state)})
        self.DeclareStateOutputPort("readout", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._tick)
        # Compiles before the clock starts.
        kernel.supervise(
            self._memory, 0.0, np.zeros(3), driver.motion, driver.state, self._no_ages, np.zeros(2),
            self._limits, self._oldest, self._next,
        )  # fmt: skip

    def request_forces(self) -> None:
        """Have the device's motors turned on again; a person's decision, from any thread."""
        self._driver.request_forces()

    def close(self) -> None:
        """Bring the device to rest."""
        self._driver.close()

    def _tick(self, context: Context, state: DiscreteValues) -> None:
        try:
            self._read_to_send(context, state)
        except BaseException:  # whatever it is, and Ctrl-C too: no force stays on while it is dealt with
            self._driver.send(np.zeros(3))
            raise

    def _read_to_send(self, context: Context, state: DiscreteValues) -> None:
        t, driver, rendered = context.get_time(), self._driver, self._rendered
        driver.read()
        self._renderer(
            t,
            driver.motion,
            self._theta.Eval(context),
            self._stable.Eval(context)[0],
            self._contact.Eval(context)[0],
            rendered,
        )
        memory, now = self._memory, self._next
        kernel.supervise(
            memory,
            t,
            rendered,
            driver.motion,
            driver.state,
            self._no_ages if self._ages is None else self._ages.Eval(context),
            self._switches.Eval(context),
            self._limits,
            self._oldest,
            now,
        )
        driver.send(now[:3])
        self._memory, self._next = now, memory
        out = state.get_mutable_value()
        out[:6], out[6:9], out[9:12], out[12:18], out[18:] = driver.motion, now[:3], rendered, now[3:9], driver.state


def _held(context: Context) -> Array:
    value: Array = context.get_discrete_state_vector().value()
    return value
