"""Stations: operator, network and telerobot as parts and nets; `table` says which, `station` builds them."""
