"""`diagnosis.json` on disk."""

from __future__ import annotations

import json
from pathlib import Path

from mmt_drake.analysis.plotting import write_whole
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.errors import BadInput, one_line
from mmt_drake.typed_yaml import read_text

_MOST_BYTES = 1 << 26


def write_diagnosis(diagnosis: Diagnosis, path: str | Path) -> Path:
    """Write `diagnosis.json` in one move; the folder is made if need be.

    Raises:
        BadInput: a number is not finite, or the file cannot be written.
    """
    path = Path(path)
    text = json.dumps(diagnosis.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
    write_whole(path, f"{text}\n".encode())
    return path


def read_diagnosis(path: str | Path) -> Diagnosis:
    """Read `diagnosis.json`.

    Raises:
        BadInput: the file cannot be read, is no JSON, or breaks the contract (`Diagnosis.from_json`).
    """
    try:
        data = json.loads(read_text(path, "a diagnosis", most=_MOST_BYTES))
    except json.JSONDecodeError as error:
        raise BadInput(path, at=f"line {error.lineno}", found=error.msg, expected="JSON") from None
    except (ValueError, RecursionError) as error:  # a number or a nesting without end
        raise BadInput(path, found=one_line(error), expected="JSON") from None
    return Diagnosis.from_json(data, str(path))
