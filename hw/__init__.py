"""Device drivers, one folder each. There are none yet."""
