"""The key that both sides share, and the ciphers made of it."""

import os
import secrets
import stat
import string
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

from mmt_drake.errors import BadInput, MissingDependency

KEY_SIZE = 32
"""Bytes of the key."""

_MAKE_ONE = "make one: (umask 077; openssl rand -hex 32 > FILE), and copy it to the other machine by a safe way"
_EXPECTED = "64 hexadecimal digits, and nothing else"


def load_key(path: str | Path) -> bytes:
    """Read the shared key.

    Args:
        path: a file of 64 hexadecimal digits that nobody but its owner, who runs this, may read or write.

    Raises:
        BadInput: there is none, others may read or write it, it belongs to another user, or it holds no key.
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError as error:
        raise BadInput(path, found=error.strerror, expected=f"a key file; {_MAKE_ONE}") from None
    try:
        _check_private(path, os.fstat(handle))  # of the file that is read, whatever the name means by now
        text = os.read(handle, 1024).strip()
    finally:
        os.close(handle)
    try:
        key = bytes.fromhex(text.decode("ascii")) if len(text) == 2 * KEY_SIZE else b""
    except ValueError:
        key = b""
    if len(key) != KEY_SIZE:
        raise BadInput(path, found=f"{len(text)} bytes that are no key", expected=_EXPECTED)
    weakness = _weakness(key)
    if weakness is not None:
        raise BadInput(path, found=f"a key that can be guessed: {weakness}", expected=f"random digits; {_MAKE_ONE}")
    return key


def _weakness(key: bytes) -> str | None:
    """What a person made it of; of random keys one in a thousand million looks like it."""
    steps = {(after - before) % 256 for before, after in pairwise(key)}
    if min(len(set(key)), len(steps)) <= KEY_SIZE // 2:
        return "its bytes repeat, or follow one another"
    return "text in hexadecimal digits" if all(byte == 0 or chr(byte) in string.printable for byte in key) else None


def _check_private(path: str | Path, status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise BadInput(path, found="no regular file", expected=f"a key file; {_MAKE_ONE}")
    if status.st_uid != os.geteuid():
        raise BadInput(path, found=f"owner {status.st_uid}", expected=f"the user who runs this, {os.geteuid()}")
    if stat.S_IMODE(status.st_mode) & 0o077:
        found = f"permissions {stat.S_IMODE(status.st_mode):04o}"
        raise BadInput(path, found=found, expected="0600, readable by its owner alone (chmod 600 FILE)")


def write_key(path: str | Path) -> None:
    """Make a new key in a new file that its owner alone may read.

    Raises:
        BadInput: the file exists, or cannot be written.
    """
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise BadInput(path, found=error.strerror, expected="a new file") from None
    with os.fdopen(handle, "w") as file:
        file.write(secrets.token_hex(KEY_SIZE) + "\n")


def derive(key: bytes, salt: bytes, use: str) -> bytes:
    """A key for one use, 32 bytes: HKDF-SHA256 (RFC 5869).

    Args:
        key: the shared key.
        salt: what is fresh.
        use: what the new key is for; keys for different uses have nothing in common.

    Raises:
        MissingDependency: the package cryptography is not installed.
    """
    library = _library()
    kdf = library.HKDF(
        algorithm=library.SHA256(), length=KEY_SIZE, salt=salt, info=b"mmt_drake link 1: " + use.encode()
    )
    derived: bytes = kdf.derive(key)
    return derived


class Cipher:
    """Seals and opens packets of one direction of one session: ChaCha20-Poly1305 (RFC 8439).

    The nonce is the packet's sequence number, of which no two may be sealed under one key.
    """

    __slots__ = ("_aead", "_bad_tag")

    def __init__(self, key: bytes) -> None:
        library = _library()
        self._aead = library.ChaCha20Poly1305(key)
        self._bad_tag = library.InvalidTag

    def seal(self, sequence: int, header: bytes, body: bytes) -> bytes:
        """The body, encrypted, and a tag over it and the header, which goes in clear."""
        sealed: bytes = self._aead.encrypt(sequence.to_bytes(12, "little"), body, header)
        return sealed

    def open(self, sequence: int, header: bytes, sealed: bytes) -> bytes | None:
        """The body; None if it was not sealed by this key, under this number, with this header."""
        try:
            body: bytes = self._aead.decrypt(sequence.to_bytes(12, "little"), sealed, header)
        except self._bad_tag:
            return None
        return body


@cache
def _library() -> SimpleNamespace:
    """What is used of the package cryptography."""
    try:
        from cryptography.exceptions import InvalidTag
        from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
        from cryptography.hazmat.primitives.hashes import SHA256
        from cryptography.hazmat.primitives.kdf.hkdf import HKDF
    except ModuleNotFoundError:
        raise MissingDependency(
            "a link between two machines: the package cryptography is not installed; "
            "pip install --constraint constraints.txt --editable '.[link]'"
        ) from None
    return SimpleNamespace(ChaCha20Poly1305=ChaCha20Poly1305, HKDF=HKDF, SHA256=SHA256, InvalidTag=InvalidTag)
