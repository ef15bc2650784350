"""Estimation by output error: the parameters whose model, running freely along the measured motion, gives the force.

The thesis's estimator fits an equation (eq. 7) in which measured force and motion stand differentiated and filtered, so
noise, the instant of a touch and friction at rest all end up in the parameters; what is rendered, though, is a model
that runs freely. Here just that is fitted: `window` keeps the samples, `smoothing` takes the noise off the motion that
drives the model, `fit` compares its force with the measured one, `learn` carries on what is known, `gate` does what
each tick needs and keeps bad samples out.
"""
