"""`view`: one address, an end, and a line for what is wrong."""

import socket
from pathlib import Path

import numpy as np
import pytest
from cli_samples import MODEL, Program, write
from table_samples import good


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    """Half a second of a probe on the table."""
    return write(tmp_path / "in.csv", good())


def free_port() -> int:
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        return int(asked.getsockname()[1])


def test_it_says_one_address_at_the_port_and_ends_by_itself(program: Program, hand: Path) -> None:
    port = free_port()
    status, out, err = program("view", hand, "--seconds", "0.3", "--port", port, "--truth", "setup1")
    assert (status, out) == (0, "") and err.startswith(f"view: http://127.0.0.1:{port}/") and err.count("\n") == 1
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port))


def test_one_of_several_recordings_is_played_by_its_number(program: Program, tmp_path: Path) -> None:
    time, ball = np.tile(np.arange(0.0, 1.0, 0.01), 2), tmp_path / "ball.npz"  # as in the public falling_balls
    np.savez(ball, drop=np.repeat([1, 2], 100), t_s=time, h_m=5.0 - 4.9 * time**2, v_mps=-9.8 * time)
    for more, told in (((), "found 2 recordings, no --number"), (("--number", 3), "found 2 recordings, no 3")):
        status, _, err = program("view", ball, *more)
        assert status == 2 and f"ball.npz: {told}, expected --number 1 to 2" in err
    assert program("view", ball, "--number", 2, "--seconds", "0.1").status == 0


def test_it_ends_when_nobody_looks(program: Program, hand: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.cli.view._IDLE_S", 0.2)
    status, _, err = program("view", hand)
    assert status == 0 and err.splitlines()[-1] == "view: ended, nobody has looked for 0.2 s"


def test_what_cannot_be_played_is_refused_in_one_line(program: Program, hand: Path) -> None:
    (hand.parent / "model.yaml").write_text(MODEL)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        for arguments, told in (
            ((hand, "--port", port), f"viewer: found port {port}, which is taken, expected a free port"),
            ((hand, "--port", "70000"), "--port: found '70000', expected a port, 1 to 65535"),
            (("nowhere.csv",), "nowhere.csv: found no such file"),
            ((hand, "--truth", "setup9"), "scenario: found setup9, expected a YAML file or one of"),
            ((hand, "--seconds", "-1"), "--seconds: found '-1'"),
        ):
            status, out, err = program("view", *arguments)
            assert (status, out) == (2, "") and told in err and err.count("\n") == 1, err


def test_a_run_takes_a_port_only_with_a_view(program: Program) -> None:
    status, _, err = program("run", "setup1", "--seconds", "0.1", "--port", free_port())
    assert status == 2 and "--port: found no --meshcat, expected --meshcat beside it" in err
