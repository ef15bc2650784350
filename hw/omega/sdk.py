"""Finds the vendor's library through its Python bindings, and says plainly what is missing."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
import sys
from dataclasses import dataclass
from types import ModuleType

from mmt_drake.errors import MissingDependency

_VENDOR = "https://www.forcedimension.com/software/sdk"


@dataclass(frozen=True)
class Sdk:
    """The modules of `forcedimension_core`.

    Attributes:
        dhd: positions, forces, settings.
        fast: the same without copies, for containers that know their addresses.
        expert: what needs expert mode.
        drd: opening and calibration.
        containers: what the bindings fill in,
        arrays: and the same as numpy arrays.
    """

    dhd: ModuleType
    fast: ModuleType
    expert: ModuleType
    drd: ModuleType
    containers: ModuleType
    arrays: ModuleType


def load_sdk() -> Sdk:
    """Import the bindings; they load the library that the variable FDSDK points to, or an installed one.

    Raises:
        MissingDependency: the bindings, the library or a new enough version of it are not here.
    """
    if importlib.util.find_spec("forcedimension_core") is None:
        version = " (for Python 3.12 or older)" if sys.version_info >= (3, 13) else ""
        raise MissingDependency(
            f"omega: Python package forcedimension-core not found{version}; get it with: pip install 'mmt_drake[omega]'"
        )
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):  # the bindings say there why, and raise without saying it
            names = ("dhd", "dhd.direct", "dhd.expert", "drd", "containers", "containers.numpy")
            return Sdk(*(importlib.import_module(f"forcedimension_core.{name}") for name in names))
    except (ImportError, AttributeError) as error:  # the latter where the library lacks a function
        why = " ".join(said.getvalue().split()) or str(error)
        raise MissingDependency(
            f"omega: Force Dimension SDK 3.16 or newer not found ({why}); download it from {_VENDOR}, unpack it and "
            "set FDSDK to its folder, or copy its lib/ to /usr/local/lib"
        ) from None
