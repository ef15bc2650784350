"""Real arms, each diagnosed on one log and held to another, and what that is worth in set-up 3."""
