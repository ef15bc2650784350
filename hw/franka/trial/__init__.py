"""The driver on trial against the emulated arm: faults of every kind at random moments, and what a tick costs."""
