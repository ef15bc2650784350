"""The packages of the optional extra `peers`."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from mmt_drake.errors import MissingDependency

_INSTALL = "install the project with its extra: pip install -e '.[peers]' -c constraints.txt"


def missing_extra() -> str | None:
    """Why the peers cannot be run, in one line; None if they can."""
    absent = [name for name in ("mujoco", "pysindy") if find_spec(name) is None]
    if absent:
        return f"{', '.join(absent)} not found; {_INSTALL}"
    # Without its own dependencies the toolbox imports as an empty module.
    if not hasattr(import_module("mujoco.sysid"), "optimize"):
        return f"mujoco.sysid is without its dependencies; {_INSTALL}"
    return None


def peer(module: str) -> Any:
    """A module of the extra.

    Raises:
        MissingDependency: the extra is not installed.
    """
    reason = missing_extra()
    if reason is not None:
        raise MissingDependency(f"peers: {reason}")
    return import_module(module)
