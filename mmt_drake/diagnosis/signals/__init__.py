"""What was recorded, made ready: one even clock, noise and rest told, position and velocity from one smoother."""
