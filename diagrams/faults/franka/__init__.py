"""The driver against the emulated arm: faults of every kind at random moments."""
