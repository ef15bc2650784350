"""Damaged files and packets for everything that reads them."""
