"""The supervisor's kernel on trial: faults of every kind at random moments of an ordinary session."""
