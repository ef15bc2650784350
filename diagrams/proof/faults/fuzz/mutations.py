"""Valid files made strange: bytes, numbers and structure, each as its form allows."""

import io
import random
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise

import numpy as np

_NO_ARCHIVE = (zipfile.BadZipFile, zlib.error, ValueError, IndexError, EOFError, OSError, RuntimeError)
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
NUMBERS = (
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e100", "1e12", "1e5", "1e-320", "1e-9", "0", "-0", "-1", "1", ""),
    *("010", "0500", "1:30", "0x1f", "1_000", ".5.", "true", "9" * 30, "9" * 5000, "18446744073709551616"),
)
_TEXTS = {
    ".csv": ('"', ",", "\n", "\r", ";", "\0", "\x1b[31m", "\ufeff", "é", "time", "file", "a," * 500, "x" * 140_000),
    ".yaml": (
        *("[" * 3000, "{a: " * 500, "&a [*a]", "*nobody", "!!float abc", "!!binary x", "!!python/name:os.system "),
        *(
            "2001-02-30",
            "2001-02-03 25:61:61",
            '"\\x1b[31m"',
            "<<: ",
            "? ",
            "- ",
            "!Scripted ",
            "null",
            "~",
            "{}",
            "[]",
        ),
        *("%YAML 9.9\n---\n", "---\n", "\t", "{", "]", ": ", "'", "!!set {a, b}", "!!omap [a]", "=", "é\0"),
        "a: &a [x,x,x,x,x,x,x,x,x]\n"
        + "".join(f"{b}: &{b} [{','.join(['*' + a] * 9)}]\n" for a, b in pairwise("abcdefghi")),
    ),
}
_ARRAYS: tuple[Callable[[np.ndarray], np.ndarray], ...] = (
    lambda a: a[:0],
    lambda a: a[:1],
    lambda a: a[:-1],
    lambda a: a[::-1],
    lambda a: np.array(a.flat[0] if a.size else 0.0),
    lambda a: a.reshape(-1, 1),
    lambda a: np.stack([a, a]),
    lambda a: np.zeros_like(a),
    lambda a: np.full(a.shape, np.nan),
    lambda a: a.astype(complex),
    lambda a: a.astype("U8"),
    lambda a: a.astype(np.float32),
    lambda a: (a != 0).astype(bool),
    lambda a: np.array([{}, None], dtype=object),
    lambda a: np.zeros(3, dtype=[("x", float)]),
    lambda a: np.where(np.arange(a.size).reshape(a.shape) > a.size // 2, a + 1e5, a),  # a clock that jumps
    lambda a: np.cumsum(np.where(np.arange(a.size) % 2, 1e-6, 0.02)).reshape(a.shape),  # ... or goes in uneven steps
)


def mutated(draw: random.Random, data: bytes, ending: str, other: bytes = b"") -> bytes:
    """A file's content with one to four things wrong in it.

    Args:
        draw: says which.
        data: what is valid.
        ending: of the file's name; its form.
        other: of another valid file, parts of which may come in.
    """
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        if ending in _TEXTS and draw.random() < 0.85:
            data = _text(draw, data, _TEXTS[ending])
        elif ending == ".npz" and draw.random() < 0.8:
            data = _npz(draw, data, other)
        elif ending == ".mcap" and draw.random() < 0.6:
            data = _mcap(draw, data, other)
        else:
            data = _bytes(draw, data, other)
    return data


def _bytes(draw: random.Random, data: bytes, other: bytes) -> bytes:
    """Flipped, cut off, cut out, repeated, overwritten, or spliced with another file."""
    at, end = sorted(draw.randrange(len(data) + 1) for _ in range(2))
    short = at + draw.randrange(1, 9)
    return draw.choice((
        lambda: data[:at] + bytes([draw.randrange(256)]) + data[at + 1 :],
        lambda: data[:at],
        lambda: data[:at] + data[end:],
        lambda: data[:end] + data[at:],
        lambda: data[:at] + draw.randbytes(short - at) + data[short:],
        lambda: data[:at] + draw.choice((b"\0", b"\xff")) * (short - at) + data[short:],
        lambda: data[:at] + other[draw.randrange(len(other) + 1) :],
    ))()  # fmt: skip


def _text(draw: random.Random, data: bytes, texts: tuple[str, ...]) -> bytes:
    """Another number; a line left out, twice, elsewhere or short; something between two words, or instead of a word."""
    what, lines, numbers = draw.randrange(9), data.split(b"\n"), list(_NUMBER.finditer(data))
    i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
    if what < 4 and numbers:
        found = draw.choice(numbers)
        return data[: found.start()] + draw.choice(NUMBERS).encode() + data[found.end() :]
    if what == 4:
        del lines[i]
    elif what == 5:
        lines.insert(j, lines[i])
    elif what == 6:
        lines[i], lines[j] = lines[j], b",".join(lines[i].split(b",")[: draw.randrange(4)])
    else:
        borders = [found.start() for found in re.finditer(rb"\b|$", data)]
        at = draw.randrange(len(borders))
        after = borders[min(at + draw.randrange(2), len(borders) - 1)]
        return data[: borders[at]] + draw.choice(texts).encode() + data[after:]
    return b"\n".join(lines)


def _npz(draw: random.Random, data: bytes, other: bytes) -> bytes:
    """Members changed as arrays or as bytes, renamed, left out or added."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        name = draw.choice(sorted(members))
    except _NO_ARCHIVE:
        return _bytes(draw, data, other)
    what, content = draw.randrange(8), members.pop(name)
    if what == 1:
        name = draw.choice(("file.npy", "time.npy", "time", "x/../y.npy", "force_x.npy", "allow_pickle.npy", "é.npy"))
    if what == 2:
        content = _bytes(draw, content, other)
    elif what == 3:
        content = draw.choice((b"", b"hello", content[: draw.randrange(1, 200)]))
    elif what == 4:  # a shape that the data do not have
        shape = draw.choice((b"(99999999999,)", b"(3, 3)", b"(-1,)", b"()", b"(10**9,)"))
        content = re.sub(rb"\(\d*,?\), } {14}", lambda m: (shape + b", }").ljust(len(m[0])), content)
    elif what > 4:
        with suppress(Exception), np.errstate(all="ignore"):  # whatever numpy makes of one that is strange already
            array, out = np.load(io.BytesIO(content)), io.BytesIO()
            changed = draw.choice(_ARRAYS)(array) if draw.random() < 0.7 else array.copy()
            if changed is not array and changed.size and changed.dtype.kind == "f" and draw.random() < 0.5:
                changed.flat[draw.randrange(changed.size)] = draw.choice((np.nan, np.inf, 1e308, 1e-320, 1e12, -1e9))
            np.save(out, changed)
            content = out.getvalue()
    if what:
        members[name] = content
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", draw.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return target.getvalue()


def _mcap(draw: random.Random, data: bytes, other: bytes) -> bytes:
    """Records left out, repeated, exchanged, changed inside, or of another length than they say."""
    records, at = [], 8
    while at + 9 <= len(data) - 8:
        size = 9 + struct.unpack_from("<Q", data, at + 1)[0]
        records.append(data[at : at + size])
        at += size
    if not records:
        return _bytes(draw, data, other)
    i, j, what = draw.randrange(len(records)), draw.randrange(len(records)), draw.randrange(5)
    if what == 0:
        del records[i]
    elif what == 1:
        records.insert(j, records[i])
    elif what == 2:
        records[i], records[j] = records[j], records[i]
    elif what == 3:
        content = _bytes(draw, records[i][9:], other)
        records[i] = records[i][:1] + struct.pack("<Q", len(content)) + content
    else:
        claimed = draw.choice((0, 1, len(records[i]), 1 << 31, 1 << 40, (1 << 64) - 1))
        records[i] = records[i][:1] + struct.pack("<Q", claimed) + records[i][9:]
    return data[:8] + b"".join(records) + data[-8:]
