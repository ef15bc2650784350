"""The supervisor's kernel: faults of every kind at random moments of an ordinary session."""
