"""Public recordings of real systems: models with known physics left out of them, diagnosed and scored."""
