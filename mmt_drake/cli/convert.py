"""``mmt-drake convert``: any recording into any other."""

from __future__ import annotations

from pathlib import Path

from mmt_drake.recording.files import check_target, load_all, save
from mmt_drake.recording.recording import Recording


def convert(source: str, target: str, topics: dict[str, str]) -> str:
    """Read every recording of ``source`` and write it in the form that the ending of ``target`` names.

    A source with several recordings gives several files: ``out.csv`` becomes ``out_1.csv``,
    ``out_2.csv`` and so on.

    Args:
        source: see ``recording.load``.
        target: ``.mcap``, ``.csv`` or ``.npz``.
        topics: see ``recording.load``.

    Returns:
        What was written and what is worth knowing about it, a few lines.

    Raises:
        BadInput: anything that ``load`` or ``save`` refuses; nothing is written then.
    """
    check_target(target)
    recordings = load_all(source, topics)
    path = Path(target)
    several = len(recordings) > 1
    lines = []
    for number, recording in enumerate(recordings, 1):
        name = path.with_stem(f"{path.stem}_{number}") if several else path
        save(recording, name)
        lines += [f"{recording.source} -> {name}: {_described(recording)}", *(f"  {note}" for note in recording.notes)]
        if path.suffix.lower() == ".csv":
            left_out = [f"{len(recording.clouds)} point clouds"] * bool(recording.clouds)
            left_out += [f"{constant} = {value:g}" for constant, value in recording.constants.items()]
            if left_out:
                lines.append(f"  not in CSV: {', '.join(left_out)}")
    return "\n".join(lines)


def _described(recording: Recording) -> str:
    duration = recording.time[-1] - recording.time[0]
    kind = recording.kind.replace("_", " ")
    return f"{kind}, {len(recording)} samples, {duration:.3f} s, {len(recording.columns)} columns beside time"
