"""Numerics that estimator and diagnosis share: least squares and low-passes."""
