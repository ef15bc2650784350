"""What may be said: the verdict, and where simulation and recording differ."""
