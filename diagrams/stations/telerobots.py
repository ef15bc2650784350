"""Telerobots that hold the probe of a scenario: the tip of an arm, or a whole one, simulated."""

from dataclasses import dataclass, replace

from pydrake.systems.framework import System

from mmt_drake.diagrams.stations.arm import Arm, simulated_arm
from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems import compliant_tip
from mmt_drake.systems.compliant_tip import TipSettings, WristSensor

_PROBE = ProbeOptions(mass=0.15, weight=(0.0, 0.0, -0.15 * 9.81))


@dataclass(frozen=True)
class CompliantTip(TipSettings):
    """The tip of an arm under impedance control, without the arm: `TipSettings`, and what is known of its probe.

    Attributes:
        compensation: what the force is cleared of; its `step` is the scenario's.
    """

    compensation: ProbeOptions = _PROBE

    def build(self, start: Array, step: float, seed: int) -> System:
        """A telerobot at rest with its tip at `start`; ports as of `mmt_drake.diagrams.stations.arm.simulated_arm`.

        Args:
            start: (3) in the table frame [m].
            step: of the simulation [s].
            seed: added to that of its sensors.
        """
        return compliant_tip.CompliantTipSystem(replace(self, sensor=_seeded(self.sensor, seed)), start, period=step)


@dataclass(frozen=True)
class Panda(Arm):
    """A whole simulated arm: `Arm`, and what is known of its probe.

    Attributes:
        compensation: as that of a `CompliantTip`.
    """

    compensation: ProbeOptions = _PROBE

    def build(self, start: Array, step: float, seed: int) -> System:
        """The same of a whole arm.

        Raises:
            MissingDependency: its model is not installed.
        """
        return simulated_arm(replace(self, sensor=_seeded(self.sensor, seed)), start, step)


def _seeded(sensor: WristSensor, seed: int) -> WristSensor:
    return replace(sensor, noise=replace(sensor.noise, seed=sensor.noise.seed + seed))
