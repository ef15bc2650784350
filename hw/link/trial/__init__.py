"""A network in memory whose every fault is chosen, for trials of a link and of what hangs on it."""
