"""The verdicts of a diagnosis."""

from __future__ import annotations

from typing import Literal

Verdict = Literal["no_mismatch", "parameters", "missing_physics", "ambiguous", "unexplained", "insufficient_data"]
