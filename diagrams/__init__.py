"""Wiring: scenarios, the station, experiments, benchmarks."""
