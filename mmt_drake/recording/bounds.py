"""Bounds on what a file may ask for, known before it is read."""

from mmt_drake.errors import BadInput

MOST = 4 * 2**30
"""Bytes that the numbers of one recording may take in memory: three hours of set-up 1 and more."""

MOST_AT_ONCE = 2**28
"""Bytes of a record of a bag, packed or not."""

MOST_COLUMNS = 1000
"""Columns, or arrays, of one file."""

_UNPACKS = 100
_ALWAYS = 2**30


def check_size(source: object, size: int) -> None:
    """Refuse numbers of more bytes than `MOST`.

    Raises:
        BadInput: so many.
    """
    if size > MOST:
        expected = f"at most {_told(MOST)} (a longer recording is to be cut into parts)"
        raise BadInput(source, found=f"numbers of {_told(size)}", expected=expected)


def check_at_once(source: object, size: int, position: int) -> None:
    """Refuse a record of a bag, at a byte of its file, that is of more bytes than `MOST_AT_ONCE`.

    Raises:
        BadInput: it is.
    """
    if size > MOST_AT_ONCE:
        at = f"byte {position}"
        raise BadInput(source, at=at, found=f"a record of {_told(size)}", expected=f"at most {_told(MOST_AT_ONCE)}")


def check_unpacked(source: object, size: int, packed: int) -> None:
    """Refuse what unpacks to a hundred times its size, and more than 1 GiB: no measurement does.

    Raises:
        BadInput: it does.
    """
    most = max(_ALWAYS, _UNPACKS * packed)
    if size > most:
        found = f"{_told(packed)} that unpack to {_told(size)} and perhaps more"
        raise BadInput(source, found=found, expected=f"at most {_told(most)}")


def _told(size: int) -> str:
    return f"{size / 2**20:.4g} MiB"
