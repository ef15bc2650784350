"""Recordings in and out of files, by the ending of their names."""

import errno
import shutil
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from tempfile import gettempdir

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording.atomic import replacing
from mmt_drake.recording.bags import load_bag, load_mcap
from mmt_drake.recording.check import mapped
from mmt_drake.recording.column_map import AS_NAMED, ColumnMap
from mmt_drake.recording.csv_file import load_csv, write_csv
from mmt_drake.recording.mcap_writer import McapWriter, whole_or_none
from mmt_drake.recording.npz_file import load_npz, write_npz
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import signals_in

WRITTEN = (".mcap", ".csv", ".npz")
READ = (*WRITTEN, ".bag", ".db3")

_BLOCK = 1.0  # seconds of recording per chunk


def load(
    path: str | Path, topics: Mapping[str, str] | None = None, *, forces: bool = True, columns: ColumnMap = AS_NAMED
) -> Recording:
    """Read the one recording of a file.

    Args:
        path: ``.mcap``, ``.csv``, ``.npz`` (the contract's columns or a public data set's), ROS 1
            ``.bag``, ROS 2 ``.db3`` or the folder of a ROS 2 bag.
        topics: for bags that name them otherwise: base name of a signal (``force``) or topic of the
            contract (``/telerobot/wrench``) -> topic of the bag.
        forces: whether three axes of position need forces beside them; not for an operator's motion.
        columns: what the columns of a file of one's own are.

    Raises:
        BadInput: the file holds several recordings, cannot be read, or breaks the contract.
    """
    recordings = load_all(path, topics, forces=forces, columns=columns)
    if len(recordings) > 1:
        names = ", ".join(recording.source for recording in recordings)
        raise BadInput(path, found=f"{len(recordings)} recordings ({names})", expected="one")
    return recordings[0]


def load_all(
    path: str | Path, topics: Mapping[str, str] | None = None, *, forces: bool = True, columns: ColumnMap = AS_NAMED
) -> list[Recording]:
    """Read every recording of a file; arguments and errors are those of ``load``."""
    path, topics = Path(path), dict(topics or {})
    try:
        return _load(path, ending_of(path), topics, forces, columns)
    except PermissionError as error:
        raise BadInput(path, found="no permission to read it", expected="a readable file") from error
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):  # long columns stand in temporary files
            raise BadInput(gettempdir(), found=error.strerror, expected=f"room for what is read of {path}") from error
        raise BadInput(path, found=error.strerror or error, expected="a readable file") from error


def _load(path: Path, ending: str, topics: dict[str, str], forces: bool, columns: ColumnMap) -> list[Recording]:
    if topics and ending in (".csv", ".npz"):
        name, topic = next(iter(topics.items()))
        raise BadInput(path, at=f"--topic {name}={topic}", found=f"a {ending} file, without topics", expected="a bag")
    if ending == ".csv":
        return [load_csv(path, forces, columns)]
    if ending == ".npz":
        return load_npz(path, forces, columns)
    return [mapped((load_mcap if ending == ".mcap" else load_bag)(path, topics, forces), columns, forces)]


def ending_of(path: Path) -> str:
    """The ending that says how to read a recording; that of a bag's folder is empty.

    Raises:
        BadInput: there is none, or it cannot be one.
    """
    if not path.exists():
        raise BadInput(path, found="no such file", expected="a recording")
    if path.is_dir():
        if not (path / "metadata.yaml").exists():
            raise BadInput(path, found="a folder without metadata.yaml", expected="a recording or a ROS 2 bag's folder")
        return ""
    ending = path.suffix.lower()
    if ending not in READ:
        raise BadInput(path, found=f"ending {ending!r}", expected=" ".join(READ))
    if path.stat().st_size == 0:
        raise BadInput(path, found="an empty file", expected="a recording")
    return ending


def check_target(path: str | Path) -> None:
    """Refuse a name under which no recording can be written, as far as the name tells.

    Raises:
        BadInput: another ending than ``.mcap``, ``.csv``, ``.npz``.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITTEN:
        raise BadInput(path, found=f"ending {ending!r}", expected=f"one that can be written: {' '.join(WRITTEN)}")


def save(recording: Recording, path: str | Path) -> None:
    """Write a recording as ``.mcap``, ``.csv`` or ``.npz``; the file is there when it is whole, not before.

    CSV keeps neither clouds nor constants, MCAP alone how it was made; MCAP keeps times to the nanosecond.

    Raises:
        BadInput: another ending, times that MCAP cannot tell apart or negative ones, or the disk refused.
    """
    check_target(path)
    ending = Path(path).suffix.lower()
    if ending == ".mcap":
        _write_mcap(recording, Path(path))
        return
    with replacing(path) as temporary:
        if ending == ".csv":
            write_csv(recording, temporary)
        else:
            write_npz(recording, temporary)


def native_of(target: Path | None, folder: str | Path) -> Path:
    """Where a run records: the ``.mcap`` that is asked for, else one in a folder that goes."""
    return target if target is not None and target.suffix.lower() == ".mcap" else Path(folder) / "run.mcap"


def kept_as_recorded(refused: BadInput, file: Path, target: str | Path) -> BadInput:
    """Keep a run's ``.mcap`` that no other format may hold beside the name that the recording was to have.

    Args:
        refused: why it may not.
        file: the ``.mcap``.
        target: the name that was asked for; ``.mcap`` is added to it.

    Returns:
        The refusal, by the name of what is kept.

    Raises:
        BadInput: the disk refused.
    """
    kept = Path(f"{target}.mcap")
    with replacing(kept) as temporary:
        shutil.copyfile(file, temporary)
    return refused.of(kept)


def _write_mcap(recording: Recording, path: Path) -> None:
    signals = signals_in(recording.columns)
    listed = [(signal.name, signal.size) for signal in signals]
    clouds = iter(recording.clouds)
    writer = McapWriter(
        path, listed, clouds=bool(recording.clouds), constants=recording.constants, made_by=recording.made_by
    )
    with whole_or_none(writer), writer:
        blocks_from = np.flatnonzero(np.diff((recording.time - recording.time[0]) // _BLOCK)) + 1
        cloud = next(clouds, None)
        for start, stop in pairwise([0, *blocks_from.tolist(), len(recording)]):
            time = recording.time[start:stop]
            while cloud is not None and cloud[0] <= time[-1]:
                writer.write_cloud(*cloud)
                cloud = next(clouds, None)
            part = slice(start, stop)
            blocks = {
                signal.name: np.column_stack([recording.columns[column][part] for column in signal.columns])
                for signal in signals
            }
            writer.write_block(time, blocks)
        while cloud is not None:
            writer.write_cloud(*cloud)
            cloud = next(clouds, None)
