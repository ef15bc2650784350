"""Kernels of the renderers of `mmt_drake.systems`: how parameters are taken up, and passivity control."""
