"""Which model files are those of arms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mmt_drake.errors import BadInput
from mmt_drake.typed_yaml import parse, read_text

STRUCTURE = "multibody"


def is_arm_file(path: str | Path) -> bool:
    """Whether a model file is one of an arm; False also where it cannot be read: others say why."""
    try:
        data = parse(read_text(path, "a model file (YAML)"), str(path))
    except BadInput:
        return False
    return isinstance(data, Mapping) and data.get("structure") == STRUCTURE
