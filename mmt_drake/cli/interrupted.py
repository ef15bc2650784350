"""What long work knew when Ctrl-C ended it, on disk."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mmt_drake.errors import Interrupted
from mmt_drake.plain import plain

FILE = "interrupted.json"


@contextmanager
def known_kept(folder: Path, command: str, name: str = FILE) -> Iterator[None]:
    """Write what is known by then to `interrupted.json`, should Ctrl-C end the work; else there is no such file.

    Args:
        folder: of the results, made if need be.
        command: that was typed.
        name: of the file, where the folder is not that of this work alone.

    Raises:
        KeyboardInterrupt: interrupted; its text says what is known, and names the file.
        BadInput: the file cannot be written.
    """
    # Imported where needed, so that help comes at once.
    from mmt_drake.analysis.plotting import write_whole

    path = folder / name
    try:
        yield
    except Interrupted as interrupt:
        if not interrupt.known:
            raise
        known = plain({"command": command, **interrupt.known}, finite=True)
        text = json.dumps(known, indent=2, ensure_ascii=False, allow_nan=False)
        write_whole(path, f"{text}\n".encode())
        raise KeyboardInterrupt(f"{interrupt}; written: {path}") from None
    path.unlink(missing_ok=True)
