"""The emulated camera: what it shows at every moment, and every kind of fault that it can have."""
