"""The state of a machine: what is installed, which devices are there, how ready it is for real time, and what to do.

examples:
  mmt-drake doctor
  mmt-drake doctor --peer 10.0.0.2
  mmt-drake doctor --json | jq '.[] | select(.status == "gap")'
"""

import argparse
import dataclasses
import importlib.metadata
import importlib.util
import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from mmt_drake.cli.machine import Check, Machine, devices, graphics, judged, real_time
from mmt_drake.cli.network import network
from mmt_drake.cli.output import add_json, console, print_json

PACKAGE = Path(__file__).resolve().parents[1]

_RESERVE_GB = 5.0  # an hour's recording, its conversion and figures


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `mmt-drake doctor`."""
    text = "also measure the way to another machine, with which this one is to run (run --side)"
    parser.add_argument("--peer", metavar="HOST", help=text)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Runs `mmt-drake doctor`; its exit status is 0 whatever is found."""
    checks = doctor(peer=arguments.peer)
    if arguments.json:
        print_json([dataclasses.asdict(check) for check in checks])
    else:
        print_checks(checks)
    return 0


def doctor(peer: str | None = None) -> list[Check]:
    """Looks at everything; takes about a second, and some more with a peer.

    Args:
        peer: name or address of another machine, to which the way is measured.

    Returns:
        The checks, grouped. `dataclasses.asdict` makes each ready for JSON.
    """
    machine = Machine()
    return [
        *packages(),
        *hardware_sdks(machine),
        *devices(machine),
        *network(machine, peer),
        *real_time(machine),
        *graphics(),
        *storage(machine),
    ]


def print_checks(checks: list[Check]) -> None:
    """Prints the checks as a table a group, each gap followed by what to do."""
    target = console()
    marks = {"ok": "[green]ok[/]", "gap": "[red]gap[/]", "optional": "[yellow]–[/]"}
    for group in dict.fromkeys(check.group for check in checks):
        table = Table(
            title=group, title_justify="left", title_style="bold", show_header=False, box=None, pad_edge=False
        )
        table.add_column(width=3)
        table.add_column(width=26)
        table.add_column(overflow="fold")
        for check in checks:
            if check.group == group:
                table.add_row(marks[check.status], check.name, escape(check.found))
                if check.advice:
                    table.add_row("", "", f"[dim]→ {escape(check.advice)}[/]")
        target.print(table)
        target.print()
    gaps = sum(check.status == "gap" for check in checks)
    target.print("Nothing to mend." if gaps == 0 else f"{gaps} to mend; – marks what only some users need.")


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def _pins() -> dict[str, str]:
    """Pinned versions of the checkout's constraints file, by normalised name; empty for an installed wheel."""
    path = PACKAGE.parent / "constraints.txt"
    lines = path.read_text().splitlines() if path.is_file() else []
    pins = (re.match(r"([\w.-]+)==([^\s;]+)", line) for line in lines)
    return {_normal(pin[1]): pin[2] for pin in pins if pin}


def _install(extra: str) -> str:
    return f".venv/bin/pip install --constraint constraints.txt --editable '.[{extra}]'"


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def packages() -> Iterator[Check]:
    """Python and every direct dependency, against the versions that were tested together."""
    group = "packages"
    here = f"{platform.python_version()} on {platform.system()} {platform.machine()}, {os.cpu_count()} CPUs"
    yield Check(group, "Python", "ok", here)
    pins = _pins()
    for requirement in importlib.metadata.requires("mmt_drake") or []:
        if "extra ==" in requirement:
            continue
        name, *_ = re.split(r"[^\w.-]", requirement, maxsplit=1)  # a requirement starts with a name
        found, pin = _version(name), pins.get(_normal(name))
        if found is None:
            yield Check(group, name, "gap", "not installed", f"make setup, or: pip install '{requirement}'")
        else:
            tested = pin in (None, found)
            yield judged(tested, group, name, found if tested else f"{found}; tested with {pin}", "make setup", "gap")


def hardware_sdks(machine: Machine) -> Iterator[Check]:
    """The Python packages of the supported devices, and the vendor library behind the haptic one."""
    group = "hardware SDKs"
    for name, extra, use in [
        ("forcedimension-core", "omega", "Force Dimension haptic devices"),
        ("franky-control", "franka", "Franka arms"),
        ("pyrealsense2", "realsense", "RealSense cameras"),
        ("cryptography", "link", "two machines (run --side)"),
    ]:
        found = _version(name)
        if found is None:
            note = " (needs Python 3.12 or older)" if extra == "omega" and sys.version_info >= (3, 13) else ""
            advice = f"for {use}: {_install(extra)}{note}"
            yield Check(group, name, "optional", "not installed", advice)
        elif extra == "franka" and int(found.split(".")[0]) < 2:
            yield Check(group, name, "gap", f"{found}; 2.0 or newer is needed", _install("franka"))
        else:
            yield Check(group, name, "ok", found)
    folders = [Path(machine.environ[key]) / "lib" for key in ("FDSDK", "FORCEDIM_SDK") if machine.environ.get(key)]
    folders += [Path(machine.environ.get("HOME", "/")) / ".local/lib", machine.root / "usr/local/lib"]
    libraries = [file for folder in folders for file in sorted(folder.glob("**/libdrd.so*"))]
    found = str(libraries[-1]) if libraries else "libdrd.so not found"
    advice = "unpack the vendor's SDK 3.16 or newer and set FDSDK to its folder, or copy its lib/ to /usr/local/lib"
    yield judged(bool(libraries), group, "Force Dimension SDK", found, advice)


def storage(machine: Machine) -> Iterator[Check]:
    """The cache of compiled kernels, room for recordings, the public recordings."""
    group = "storage"
    chosen, home = machine.environ.get("NUMBA_CACHE_DIR"), Path(machine.environ.get("HOME", "/"))
    folders = [Path(chosen)] if chosen else [PACKAGE, home]  # numba falls back from beside the source to the user's
    cache = next((folder for folder in folders if os.access(folder, os.W_OK)), None)
    found = f"no write access to {folders[0]}" if cache is None else f"cached in {cache}"
    advice = "every start compiles all kernels anew; set NUMBA_CACHE_DIR to a folder you may write to"
    yield judged(cache is not None, group, "compiled kernels", found, advice, "gap")
    here = Path.cwd()
    free = shutil.disk_usage(here).free / 1e9
    advice = f"recordings need room: have {_RESERVE_GB:.0f} GB free, or work in another folder"
    yield judged(free >= _RESERVE_GB, group, "free disk", f"{free:.1f} GB in {here}", advice, "gap")
    chosen = machine.environ.get("MMT_RECORDINGS")
    recordings = Path(chosen) if chosen else PACKAGE.parents[1] / "shared" / "recordings"
    if recordings.is_dir():
        yield Check(group, "public recordings", "ok", str(recordings))
    elif chosen:
        found = f"MMT_RECORDINGS names {chosen}, which is no folder"
        advice = "name the folder that holds emps/, bam_servo/ and the others"
        yield Check(group, "public recordings", "gap", found, advice)
    else:
        advice = "tests on real recordings are skipped; set MMT_RECORDINGS to their folder"
        yield Check(group, "public recordings", "optional", "MMT_RECORDINGS is not set", advice)
