"""Force Dimension haptic devices (Omega, Delta, Sigma, Lambda): driver, Drake system, emulator."""
