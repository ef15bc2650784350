"""Motions of the operator's hand: scripted, recorded, or modelled after a human's."""
