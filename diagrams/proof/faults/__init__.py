"""Faults of every kind, from a device's motors to a recording's end: tests import them, `bench faults` runs them."""
