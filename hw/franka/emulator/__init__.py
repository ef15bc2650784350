"""A simulated Franka behind the robot's own network protocol, in a process of its own, on loopback."""

from hw.franka.emulator.emulated import EmulatedFranka

__all__ = ["EmulatedFranka"]
