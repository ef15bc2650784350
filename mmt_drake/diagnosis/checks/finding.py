"""The finding of a check."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Severity = Literal["refuse", "warn", "note"]


@dataclass(frozen=True)
class Finding:
    """Something the check before the diagnosis saw: a code, how bad it is, a sentence, and its figures by name."""

    code: str
    severity: Severity
    text: str
    figures: Mapping[str, float] = field(default_factory=dict)
