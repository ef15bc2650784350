"""Franka arms: driver, Drake system, emulator."""
