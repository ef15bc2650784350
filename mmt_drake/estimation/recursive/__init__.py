"""Recursive estimation: each sample is used once and forgotten, so cost and memory stay what they are.

Two forms, with the ports of the window of output error and behind the same gate (`mmt_drake.estimation.output_error`):
a Kalman filter over the body's motion and the parameters (`kalman`), and the refined instrumental variable on the
thesis's regressors (`instrumental`).
"""
