"""Wiring: the stations that scenarios describe, and the proof of what this project claims."""
