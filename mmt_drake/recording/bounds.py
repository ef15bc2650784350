"""How much a file may ask for, known before it is read."""

from __future__ import annotations

from mmt_drake.errors import BadInput

MOST = 4 * 2**30
"""Bytes that the numbers of one recording may take in memory: three hours of set-up 1, and more."""

MOST_AT_ONCE = 2**28
"""Bytes of a chunk of a bag, unpacked, and of a line of CSV."""

MOST_COLUMNS = 1000
"""Columns, or arrays, of one file."""

_TIMES = 100  # its own size, that a small file may unpack to
_ALWAYS = 2**30


def check_size(source: object, size: int, *, at: object = None, packed: int | None = None) -> None:
    """Refuse what would take too much memory.

    Args:
        source: the file.
        size: of what is about to be read, in bytes.
        at: where in the file.
        packed: size of the file that unpacks to this much, which may be a hundred times as much, and 1 GiB always.

    Raises:
        BadInput: it is more than `MOST`, or than a file of that size holds of measured data.
    """
    most = MOST if packed is None else min(MOST, max(_ALWAYS, _TIMES * packed))
    if size > most:
        expected = f"at most {most / 2**20:.0f} MiB; is it damaged? A longer recording is to be cut into parts"
        raise BadInput(source, at=at, found=f"{size / 2**20:.0f} MiB of numbers", expected=expected)
