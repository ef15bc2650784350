"""Where a simulation and a recording differ, what physics was left out, and the fit that proves it."""
