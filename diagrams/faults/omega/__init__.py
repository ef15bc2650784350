"""The driver against the emulated haptic device: faults of every kind at random moments."""
