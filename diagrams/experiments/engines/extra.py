"""The packages of the optional extra `engines`."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from mmt_drake.errors import MissingDependency

_INSTALL = "install the project with its extra: pip install -e '.[engines]' -c constraints.txt"


def missing(package: str) -> str | None:
    """Why an engine cannot be run, in one line; None if it can."""
    return f"{package} not found; {_INSTALL}" if find_spec(package) is None else None


def engine_package(package: str) -> Any:
    """A package of the extra, imported.

    Raises:
        MissingDependency: it is not installed.
    """
    reason = missing(package)
    if reason is not None:
        raise MissingDependency(f"engines: {reason}")
    return import_module(package)
