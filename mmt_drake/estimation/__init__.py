"""Estimation of the environment's impedance from position, velocity and force: the thesis's recursive least squares."""
