"""Motions of the operator's hand: scripted or recorded."""
