"""Truths of a trial's cases, sealed: a hash of all of them is published before the first diagnosis."""

import hashlib
import json
from collections.abc import Sequence
from typing import Any, Protocol


class Sealed(Protocol):
    """A case with a truth."""

    def truth(self) -> dict[str, Any]:
        """What is concealed, as plain numbers and strings."""


def canonical(cases: Sequence[Sealed]) -> str:
    """The one JSON text of all truths: keys sorted, no spaces."""
    truths = [case.truth() for case in cases]
    return json.dumps(truths, sort_keys=True, separators=(",", ":"), allow_nan=False)


def seal(cases: Sequence[Sealed]) -> str:
    """The sha256 of all truths, to be published before the first diagnosis."""
    return hashlib.sha256(canonical(cases).encode()).hexdigest()
