"""A key is read only from a file that nobody else can read; ciphers are those of the RFCs."""

import os
import random
import stat
from pathlib import Path

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.hw.link.keys import Cipher, derive, load_key, write_key

KEY = "8f0b62d1e97a3c5546f1d80e2bc3974a10a5ee6d7f843b29c25706fd91b8e43c"


def key_file(folder: Path, text: str = KEY, mode: int = 0o600) -> Path:
    path = folder / "link.key"
    path.write_text(text)
    path.chmod(mode)
    return path


def test_a_key_that_was_written_is_read_again_and_its_owner_alone_may_read_it(tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_key(tmp_path / name)
        assert stat.S_IMODE((tmp_path / name).stat().st_mode) == 0o600
    assert load_key(tmp_path / "one") != load_key(tmp_path / "two")
    assert load_key(key_file(tmp_path, KEY + "\n")) == bytes.fromhex(KEY)


def test_a_key_is_never_written_over(tmp_path: Path) -> None:
    path = key_file(tmp_path)
    with pytest.raises(BadInput, match="a new file"):
        write_key(path)
    assert path.read_text() == KEY


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660, 0o602, 0o610, 0o777])
def test_a_key_that_others_may_read_or_write_is_refused(tmp_path: Path, mode: int) -> None:
    with pytest.raises(BadInput, match=f"{mode:04o}.*chmod 600"):
        load_key(key_file(tmp_path, mode=mode))


def test_a_key_of_another_user_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = key_file(tmp_path)
    monkeypatch.setattr(os, "geteuid", lambda: path.stat().st_uid + 1)
    with pytest.raises(BadInput, match="owner"):
        load_key(path)


@pytest.mark.parametrize("text", ["", KEY[:-1], KEY + "00", "g" + KEY[1:], "é" * 32, KEY.replace("0", " ")])
def test_what_is_no_key_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(BadInput, match="64 hexadecimal digits"):
        load_key(key_file(tmp_path, text))


GUESSED = {
    "one digit": "0" * 64,
    "counted up": bytes(range(32)).hex(),
    "counted down in steps": bytes(range(255, 159, -3)).hex(),
    "a pattern again and again": "00ff5aa5" * 8,
    "half of it twice": bytes([17, 203, 99, 4, 55, 180, 240, 31, 77, 129, 6, 250, 143, 68, 222, 35] * 2).hex(),
    "a password": b"correct horse battery staple 42!".hex(),
    "a short password": b"hunter2 and some more of it".ljust(32, b"\0").hex(),
}


@pytest.mark.parametrize("text", GUESSED.values(), ids=GUESSED)
def test_a_key_that_can_be_guessed_is_refused_with_the_way_to_make_one(text: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"guessed.*openssl rand"):
        load_key(key_file(tmp_path, text))


def test_random_keys_are_taken(tmp_path: Path) -> None:
    draw = random.Random(4)
    for n in range(200):
        folder = tmp_path / str(n)
        folder.mkdir()
        key = draw.randbytes(32)
        assert load_key(key_file(folder, key.hex())) == key


def test_what_is_no_file_is_refused_without_waiting_for_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, Path(os.devnull)):
        with pytest.raises(BadInput):
            load_key(path)
    with pytest.raises(BadInput, match="openssl rand"):
        load_key(tmp_path / "missing")


def test_the_error_of_a_bad_key_does_not_show_it(tmp_path: Path) -> None:
    with pytest.raises(BadInput) as refused:
        load_key(key_file(tmp_path, KEY + "ff"))
    assert KEY[:16] not in str(refused.value)


def test_packets_are_sealed_by_chacha20_poly1305_with_the_number_as_nonce() -> None:
    """Against the example of RFC 8439, 2.8.2, whose nonce is read as a little-endian number."""
    cipher = Cipher(bytes(range(0x80, 0xA0)))
    nonce = bytes.fromhex("070000004041424344454647")
    number = int.from_bytes(nonce, "little")
    header = bytes.fromhex("50515253c0c1c2c3c4c5c6c7")
    text = (
        b"Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, "
        b"sunscreen would be it."
    )
    sealed = cipher.seal(number, header, text)
    assert sealed[:16].hex() == "d31a8d34648e60db7b86afbc53ef7ec2"
    assert sealed[-16:].hex() == "1ae10b594f09e26a7e902ecbd0600691"
    assert cipher.open(number, header, sealed) == text
    for other in ((number + 1, header, sealed), (number, header[:-1] + b"x", sealed), (number, header, sealed[:-1])):
        assert cipher.open(*other) is None


def test_keys_for_different_uses_and_salts_differ() -> None:
    key = bytes(range(32))
    keys = {derive(key, salt, use) for salt in (b"a" * 32, b"b" * 32) for use in ("from operator", "from telerobot")}
    assert len(keys) == 4 and all(len(made) == 32 for made in keys)
