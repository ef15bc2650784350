"""Finds the vendor's library through its Python bindings, and says plainly what is missing."""

import contextlib
import importlib
import importlib.util
import io
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
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


def load_sdk(library: str | Path | None = None) -> Sdk:
    """Import the bindings, which load the vendor's library; a process has one library, the first that it loads.

    Args:
        library: folder of the vendor's SDK; by default the one that the variable FDSDK names, or an installed one.

    Raises:
        MissingDependency: the bindings, the library or a new enough version of it are not here; or another one than
            that was loaded before.
    """
    if importlib.util.find_spec("forcedimension_core") is None:
        version = " (for Python 3.12 or older)" if sys.version_info >= (3, 13) else ""
        raise MissingDependency(
            f"omega: Python package forcedimension-core not found{version}; get it with: pip install 'mmt_drake[omega]'"
        )
    said = io.StringIO()
    try:
        with _named(library), contextlib.redirect_stderr(said):  # the bindings say there why, and raise without it
            names = ("dhd", "dhd.direct", "dhd.expert", "drd", "containers", "containers.numpy")
            sdk = Sdk(*(importlib.import_module(f"forcedimension_core.{name}") for name in names))
    except (ImportError, AttributeError) as error:  # the latter where the library lacks a function
        why = " ".join(said.getvalue().split()) or str(error)
        where = "" if library is None else f" in {library}"
        raise MissingDependency(
            f"omega: Force Dimension SDK 3.16 or newer not found{where} ({why}); download it from {_VENDOR}, unpack it "
            "and set FDSDK to its folder, or copy its lib/ to /usr/local/lib"
        ) from None
    if library is not None and Path(library).resolve() not in loaded_library().resolve().parents:
        raise MissingDependency(f"omega: no library in {library}; this process uses {loaded_library()}")
    return sdk


def loaded_library() -> Path:
    """The library that the bindings of this process have loaded."""
    return Path(importlib.import_module("forcedimension_core.runtime")._libdrd._name)


@contextlib.contextmanager
def _named(library: str | Path | None) -> Iterator[None]:
    """FDSDK names a folder meanwhile; None leaves it as it is."""
    before = os.environ.get("FDSDK")
    if library is not None:
        os.environ["FDSDK"] = str(library)
    try:
        yield
    finally:
        if before is not None:
            os.environ["FDSDK"] = before
        elif library is not None:
            del os.environ["FDSDK"]
