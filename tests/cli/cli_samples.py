"""What tests of the command line share: a command's outcome; recordings, right and wrong, written unchecked."""

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_typestore
from table_samples import Columns, csv_text

from mmt_drake.recording import McapWriter

#: `python -c PATIENT ...` is `mmt-drake ...` whose haptic device does not notice the pauses of a busy machine.
PATIENT = """import sys
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.diagrams.proof.faults.patient_clock import PatientClock
from mmt_drake.cli.main import main
Hand.__init__.__kwdefaults__["supervisor_clock"] = PatientClock()
sys.exit(main())"""


class Outcome(NamedTuple):
    """What a command left: exit status and both streams."""

    status: int
    out: str
    err: str


Program = Callable[..., Outcome]

MODEL = "structure: flexible_box\nparameters: {m: 1.0, k1: 0.0, k2: 500.0, b1: 60.0, b2: 60.0, Fc: 0.05}\n"


def write(path: Path, columns: Columns) -> Path:
    """A recording by its ending, unchecked."""
    if path.suffix == ".csv":
        path.write_text(csv_text(columns))
    elif path.suffix == ".npz":
        np.savez(path, **cast(dict[str, Any], columns))
    elif path.suffix == ".mcap":
        names = {"position": 3, "velocity": 3, "force": 3, "in_contact": 1}
        names = {name: size for name, size in names.items() if name in columns or f"{name}_x" in columns}
        with McapWriter(path, list(names.items())) as writer:
            blocks = {
                name: columns[name] if size == 1 else np.column_stack([columns[f"{name}_{a}"] for a in "xyz"])
                for name, size in names.items()
            }
            writer.write_block(columns["time"], blocks)
    else:
        write_bag(path, columns)
    return path


def write_bag(path: Path, columns: Columns, topic: str = "/telerobot/pose", kind: str = "Vector3") -> Path:
    """A ROS 1 bag with the probe's position alone."""
    store = get_typestore(Stores.ROS1_NOETIC)
    message = store.types[f"geometry_msgs/msg/{kind}"]
    with Ros1Writer(path) as bag:
        connection = bag.add_connection(topic, message.__msgtype__, typestore=store)
        for row, time in enumerate(columns["time"]):
            content = message(*(float(columns[f"position_{axis}"][row]) for axis in "xyz"))
            bag.write(connection, round(time * 1e9), store.serialize_ros1(content, message.__msgtype__))
    return path


@contextmanager
def disk_of(size: str, folder: Path) -> Iterator[Path]:
    """A disk made of memory, `size` as mount has it (64k, 1m); the test is skipped where it may not be mounted."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("no right to mount a small disk")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def text(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def listing(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))
