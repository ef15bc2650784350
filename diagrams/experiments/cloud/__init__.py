"""Contact detection on a measured cloud: the experiment the thesis planned and did not make, in simulation.

`python -m diagrams.experiments.cloud --out DIR` makes it.
"""
