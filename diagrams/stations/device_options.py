"""Devices as a scenario describes them; what opens them is `mmt_drake.diagrams.stations.devices`."""

from dataclasses import dataclass, field, replace

from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.safety.limits import SafetyLimits


@dataclass(frozen=True)
class Omega(OmegaSettings):
    """A Force Dimension device that an operator holds: `OmegaSettings`, and what it may do.

    Attributes:
        limits: force, power and speed of the device itself, whatever it is scaled by; the box is in the table frame.
    """

    limits: SafetyLimits = field(default_factory=SafetyLimits)

    def table_limits(self) -> SafetyLimits:
        """The same as the supervisor before it has to keep them, which sees forces and motions of the table frame."""
        limits, felt, moved = self.limits, self.force_scale, self.scale
        return replace(limits, force=limits.force / felt, power=limits.power * moved / felt, speed=limits.speed * moved)


@dataclass(frozen=True)
class Franka(FrankaSettings):
    """An arm that probes a real object: `FrankaSettings`, and what is known of its probe.

    Attributes:
        compensation: what the robot's estimate of the force is cleared of, without what the robot itself knows of
            (`load_mass`); its `step` is the scenario's.
    """

    address: str = "172.16.0.2"
    compensation: ProbeOptions = field(default_factory=ProbeOptions)
