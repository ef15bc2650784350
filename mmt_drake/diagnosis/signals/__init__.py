"""Recorded signals made ready: one even clock, noise and rest known, position and velocity from one smoother."""
