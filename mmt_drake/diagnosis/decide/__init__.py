"""The decision: the verdict, and where simulation and recording differ."""
