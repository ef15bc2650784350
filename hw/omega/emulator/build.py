"""Builds a shared library that the real Python bindings load in place of the vendor's.

Every name that the bindings refer to must be there, or they cannot be imported. So the names, and the type that each
returns, are read from the installed bindings; those that `handle.c` does not define become functions that fail with
the library's own error 'not implemented'.
"""

import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.omega.emulator.emulated import FIELDS
from mmt_drake.hw.omega.sdk import load_sdk

_SOURCE = Path(__file__).with_name("handle.c")
_REFERRED = re.compile(r"_libd[hr]d\.(d[hr]d\w+)\b(?:\.restype = (\w+))?")
_DEFINED = re.compile(r"^[\w* ]+?\b(d[hr]d\w+)\(", re.MULTILINE)
_C_TYPES = {
    "None": "void",
    "c_int": "int",
    "c_uint": "unsigned",
    "c_bool": "bool",
    "c_double": "double",
    "c_byte": "signed char",
    "c_char_p": "const char *",
}
_NAME = "libdrd.so.3.17.1" if sys.platform != "darwin" else "libdrd.3.17.1.dylib"


def referred_names() -> dict[str, str]:
    """Every function of the vendor's library that the installed bindings refer to, and the C type of its result.

    Raises:
        MissingDependency: the bindings are not installed.
    """
    found = importlib.util.find_spec("forcedimension_core")
    if found is None or not found.submodule_search_locations:
        raise MissingDependency("emulator: forcedimension-core not found; pip install 'mmt_drake[omega]'")
    names: dict[str, str] = {}
    for folder in found.submodule_search_locations:
        for file in sorted(Path(folder).rglob("*.py")):
            for name, result in _REFERRED.findall(file.read_text()):
                if result or name not in names:
                    names[name] = _C_TYPES.get(result, "int")
    return names


def build_library(folder: Path) -> Path:
    """Compile the library as the bindings look for it under the folder that `FDSDK` names.

    Args:
        folder: becomes such a folder.

    Returns:
        The library's path.

    Raises:
        MissingDependency: the bindings or a C compiler are not installed, or it does not compile.
    """
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise MissingDependency("emulator: no C compiler found; install gcc, or name one in CC")
    system, kind = ("mac", "clang") if sys.platform == "darwin" else ("lin", "gcc")
    target = folder / "lib" / "release" / f"{system}-{platform.machine()}-{kind}" / _NAME
    target.parent.mkdir(parents=True, exist_ok=True)
    (folder / "emulated.h").write_text(_header())
    (folder / "missing.c").write_text(_missing())
    command = [compiler, "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra"]
    command += [f"-I{folder}", str(_SOURCE), str(folder / "missing.c"), "-o", str(target), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["nothing"])[0]
        raise MissingDependency(f"emulator: {compiler} does not compile it and says: {said}")
    return target


_LOADED: list[Path] = []


def load_emulated(folder: Path) -> Path:
    """Build the library and have the bindings of this process load it, as they would the vendor's: one, once.

    Args:
        folder: where to build it, if this process has none yet.

    Returns:
        The library's path, for `EmulatedOmega`.

    Raises:
        MissingDependency: as `build_library`; or the bindings have loaded another library already.
    """
    if not (_LOADED and _LOADED[0].is_file()):
        path = build_library(folder)
        load_sdk(folder)
        _LOADED[:] = [path]
    return _LOADED[0]


def _header() -> str:
    names = ", ".join(f'"{name}"' for name in FIELDS)
    members = f"struct emulated {{ double {', '.join(FIELDS)}; }};"
    return f"{members}\nstatic const char *const emulated_names[] = {{{names}}};\n"


def _missing() -> str:
    """C of the functions that `handle.c` leaves out. No parameters are declared: none is looked at."""
    defined = set(_DEFINED.findall(_SOURCE.read_text()))
    results = {"void": "return;", "bool": "return false;", "double": "return -1.0;", "const char *": 'return "";'}
    lines = ["#include <stdbool.h>"]
    for name, kind in sorted(referred_names().items()):
        if name not in defined:
            lines.append(f"{kind} {name}(void) {{ {results.get(kind, 'return -1;')} }}")
    return "\n".join(lines) + "\n"
