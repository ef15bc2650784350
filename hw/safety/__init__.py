"""Safety between a computed force and any device: limits, faults, a ramp to zero, and a person who re-arms."""
