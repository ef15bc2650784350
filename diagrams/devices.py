"""The devices of a scenario: what is connected, and the hand on it in place of a simulated one."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType, TracebackType
from typing import Self

from hw.omega import OmegaOperator
from hw.omega.settings import OmegaSettings
from hw.safety import OperatorSwitch, SafetyLimits, supervised

_NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Omega(OmegaSettings):
    """A Force Dimension device that an operator holds: `OmegaSettings`, and what it may do.

    Attributes:
        limits: of the supervisor before it.
    """

    limits: SafetyLimits = field(default_factory=SafetyLimits)


class Hand:
    """A person's hand on a device, behind a supervisor, as a station takes it in place of a simulated one.

    The device is open from here on and has to be closed. It makes no force before a person has armed it.

    Attributes:
        system: with the ports of `supervised`.
        switch: arms and stops, from any thread.
        watched: name -> greatest age [s] of what must stay fresh.

    Args:
        device: which one, and what it may do.
        period: of the ticks [s].
        watched: as `SafetySupervisor` takes it.
        clock: of readings and switches [s], never set.

    Raises:
        BadInput: limits that cannot be kept at this period.
        MissingDependency, DeviceError: as `OmegaDevice`.
    """

    def __init__(
        self,
        device: Omega,
        period: float,
        watched: Mapping[str, float] = _NOTHING,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._operator = OmegaOperator(device, period=period, clock=clock)
        try:
            self.switch = OperatorSwitch(period=period, clock=clock, on_arm=self._operator.request_forces)
            self.system = supervised(self._operator, device.limits, period=period, watched=watched, switch=self.switch)
        except BaseException:
            self.close()
            raise
        #: As the device calls itself.
        self.name = self._operator.device.name
        self.watched = watched

    def close(self) -> None:
        """Bring the device to rest; may be called again."""
        self._operator.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
