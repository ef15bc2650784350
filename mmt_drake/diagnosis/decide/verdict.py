"""The verdicts of a diagnosis."""

from typing import Literal

Verdict = Literal[
    "no_mismatch", "parameters", "missing_physics", "partly_explained", "ambiguous", "unexplained", "insufficient_data"
]
NAMING: frozenset[Verdict] = frozenset(("missing_physics", "partly_explained", "ambiguous"))
"""Verdicts that name effects."""
