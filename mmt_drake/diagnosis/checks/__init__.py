"""Checks whether a recording can be diagnosed at all: its clock, sensors, motion and signs."""
