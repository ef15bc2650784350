"""A simulated Franka behind the robot's own network protocol, in a process of its own, on loopback."""

from mmt_drake.hw.franka.emulator.emulated import EmulatedFranka

__all__ = ["EmulatedFranka"]
