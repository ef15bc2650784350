"""A network in memory whose every fault is chosen, for a link and what hangs on it."""
