"""The layout of a packet; all numbers little-endian.

| part | bytes | |
| --- | --- | --- |
| header | 16 | `MMTL`, version 2, kind, the session's tag (2), sequence number (8); in clear, authenticated |
| HELLO: number of the sender's start | 16 | in clear, authenticated; then sealed: the sender's role (1), digest of what the link carries (16); behind the tag a mark (16), BLAKE2s keyed over all before it, which is checked before any cipher is made |
| others, sealed: times | 28 | sender's time of sending, newest time received from the peer, how long that was held [ns] (8 each); number of the newest complete surface (4) |
| DATA | 8 + 8 n | when its tick was due, on the sender's clock [ns] (8); the vector, in double precision |
| TRANSLATION | 36 | surface number (4), stamp [s], translation [m] (3) |
| BLOCK | 12 + 12 k | surface number (4), which block (2), of how many (2), points of the surface (4); k points in single precision |
| ALIVE, BYE | 0 | |
| tag | 16 | Poly1305 over header and body |
"""  # noqa: E501

import struct
from typing import NamedTuple

MAGIC = b"MMTL"
VERSION = 2
HELLO, DATA, TRANSLATION, BLOCK, ALIVE, BYE = range(1, 7)
KINDS = range(HELLO, BYE + 1)

_HEADER = struct.Struct("<4sBBHQ")
TIMES = struct.Struct("<QQQI")
TIME = struct.Struct("<Q")
HEADER_SIZE = _HEADER.size
TIMES_SIZE = TIMES.size
TAG_SIZE = 16
START_SIZE = 16
DIGEST_SIZE = 16
MARK_SIZE = 16
HELLO_SIZE = HEADER_SIZE + START_SIZE + 1 + DIGEST_SIZE + TAG_SIZE + MARK_SIZE
LEAST_SIZE = HEADER_SIZE + TIMES_SIZE + TAG_SIZE
LARGEST_SIZE = 1280
"""A packet never exceeds what every IPv6 network must carry whole, less its own headers."""


class Times(NamedTuple):
    """The times in a packet, which open its sealed body (`TIMES`).

    Attributes:
        sent: when it was sent, on the sender's clock [ns].
        echo: the newest `sent` that the sender had received from its peer [ns]; 0: none.
        held: how long before this packet that had come [ns].
        surface: number of the newest surface that the sender has complete; 0: none.
    """

    sent: int
    echo: int
    held: int
    surface: int


def header(kind: int, tag: int, sequence: int) -> bytes:
    """The first 16 bytes."""
    return _HEADER.pack(MAGIC, VERSION, kind, tag, sequence)


def read_header(datagram: bytes) -> tuple[int, int, int] | None:
    """Kind, session's tag and sequence number; None if it is no packet of this link or version."""
    if not LEAST_SIZE <= len(datagram) <= LARGEST_SIZE:
        return None
    magic, version, kind, tag, sequence = _HEADER.unpack_from(datagram)
    if magic != MAGIC or version != VERSION or kind not in KINDS:
        return None
    return kind, tag, sequence
