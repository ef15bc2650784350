"""The driver on trial against the emulated device: faults of every kind at random moments, and what a tick costs."""
