"""Differences between a simulation and a recording: located, named, modelled, and the fit that proves it."""
