"""Targets of damaged files and packets: the undamaged ones, and every program that reads them."""

import asyncio
import os
import random
import socket
from contextlib import suppress
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from mmt_drake.cloud import Cloud
from mmt_drake.cloud.files import read_cloud, write_cloud
from mmt_drake.diagrams.proof.faults.fuzz.harness import Fuzz, Program, Target
from mmt_drake.diagrams.proof.faults.fuzz.mutations import NUMBERS, mutated
from mmt_drake.diagrams.proof.faults.wires import End, FaultyWire, at_once
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.shipped import SCENARIOS
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.hw.link import wire
from mmt_drake.hw.link.keys import load_key, write_key
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions, LinkSignal, Role
from mmt_drake.model_files import load_model
from mmt_drake.network.config import load_trace
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.files import WRITTEN
from mmt_drake.simulation import simulate
from mmt_drake.typed_yaml import fill, override, parse
from mmt_drake.viewer.serve import Server

MODELS = {
    "flexible_box": "structure: flexible_box\nparameters: {m: 0.5, k1: 0.0, k2: 450.0, b1: 20.0, b2: 25.0, Fc: 0.05}\n"
    "normal: {k: 400.0, b: 8.0}\neffects:\n  - {name: static_friction, parameters: {Fs: 0.1, Fd: 0.05, v_d: 0.005}}\n",
    "kelvin_voigt": "structure: kelvin_voigt\nparameters: {k: 450.0, b: 22.0, x0: 0.01}\n",
    "driven_body": "structure: driven_body\nparameters: {m: 1.8, b: 11.0, k: 80.0, Fc: 0.5}\n"
    "gravity: {kind: pendulum, value: 0.5}\n",
    "transmission": "structure: transmission\nparameters: {ratio: -0.5, offset: 0.1, Fc: 0.01, c: 0.02}\n"
    "effects:\n  - {name: gear_play, parameters: {gap: 0.03}}\n",
}
RECORDED = {"flexible_box": "contact", "kelvin_voigt": "axis", "driven_body": "driven", "transmission": "geared"}
"""Structure -> name of its recording."""
_SHORT = ("--time-budget", "3")  # a search without end would hide a hang


def write_seeds(folder: Path) -> None:
    """Write models, what they answer to a motion as `.csv`, `.npz` and `.mcap`, bags, clouds, scenarios, trace, key."""
    t = np.arange(0.0, 0.6, 0.005)
    moves = {
        "contact": {"position_x": 0.0 * t, "position_y": 0.02 * np.sin(9.0 * t), "position_z": 0.004 * np.cos(8.0 * t)},
        "axis": {"position": 0.02 * np.sin(9.0 * t)},
        "driven": {"input": 5.0 * np.sin(9.0 * t), "output": 0.0 * t},
        "geared": {"input": 0.3 * np.sin(9.0 * t), "output": 0.0 * t},
    }
    for structure, name in RECORDED.items():
        (folder / f"{structure}.yaml").write_text(MODELS[structure])
        motion = Recording(t, moves[name] | ({"force": 0.0 * t} if name == "axis" else {}), name)
        save(motion, folder / f"{name}.csv")
        recording = simulate(load_model(folder / f"{structure}.yaml"), load(folder / f"{name}.csv", forces=False))
        for ending in (".csv", ".npz", ".mcap"):
            if ending != ".mcap" or name == "contact":
                save(recording, folder / f"{name}{ending}")
        if name == "driven":  # as one of the public data sets has it
            np.savez(folder / "public.npz", t_s=t, u_V=t, force_N=recording["input"], q_m=recording["output"])
    _write_bags(folder, t, np.column_stack(list(moves["contact"].values())))
    grid = np.linspace(-0.05, 0.05, 15)
    points = np.column_stack([np.repeat(grid, 15), np.tile(grid, 15), np.zeros(225)])
    for ending in (".ply", ".pcd", ".xyz"):
        write_cloud(Cloud(points), folder / f"cloud{ending}")
    for scenario in SCENARIOS.glob("*.yaml"):
        (folder / scenario.name).write_text(scenario.read_text())
        # What has to be compiled is, before the clock starts.
        build_station(load_scenario(scenario, trust_library=True)).simulate(0.002)
    write_key(folder / "link.key")
    rows = (f"{0.01 * k:.2f},{0.02 + 1e-3 * k:g}\n" for k in range(50))
    (folder / "trace.csv").write_text("".join(["time,delay\n", *rows]))


def _write_bags(folder: Path, t: np.ndarray, positions: np.ndarray) -> None:
    """One motion as a ROS 1 bag and as a ROS 2 database."""
    ros1, ros2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    for store, writer, serialize in (
        (ros1, Writer1(folder / "motion.bag"), ros1.serialize_ros1),
        (ros2, Writer2(folder / "ros2", version=9), ros2.serialize_cdr),
    ):
        vector = store.types["geometry_msgs/msg/Vector3"]
        with writer as bag:
            connection = bag.add_connection("/telerobot/pose", vector.__msgtype__, typestore=store)
            for time, position in zip(t, positions, strict=True):
                bag.write(connection, round(1e9 * (1.0 + time)), serialize(vector(*position), vector.__msgtype__))
    next((folder / "ros2").glob("*.db3")).rename(folder / "motion.db3")


def _strange(draw: random.Random, seeds: Path, *names: str, to: str = "in") -> str:
    """One of these valid files, mutated, in the present folder; its name there."""
    source = seeds / draw.choice(names)
    other = draw.choice(sorted(path for path in seeds.iterdir() if path.is_file()))
    target = Path(f"{to}{source.suffix}")
    target.write_bytes(mutated(draw, source.read_bytes(), source.suffix, other.read_bytes()))
    return str(target)


def _convert(draw: random.Random, seeds: Path) -> list[str]:
    forms = [f"{name}{ending}" for name in ("contact", "axis", "driven") for ending in WRITTEN]
    there = [form for form in forms if (seeds / form).exists()]
    there += ["contact.mcap", "public.npz", "motion.bag", "motion.db3"]
    return ["convert", _strange(draw, seeds, *there), f"out{draw.choice(WRITTEN)}"]


def _replayed(draw: random.Random, seeds: Path, structure: str) -> tuple[str, str]:
    """A model file and its recording, one of them strange."""
    model, recording = f"{structure}.yaml", f"{RECORDED[structure]}{draw.choice(('.csv', '.npz'))}"
    if draw.random() < 0.5:
        return _strange(draw, seeds, model), str(seeds / recording)
    return str(seeds / model), _strange(draw, seeds, recording)


def _simulate(draw: random.Random, seeds: Path) -> list[str]:
    model, recording = _replayed(draw, seeds, draw.choice(list(RECORDED)))
    return ["simulate", "--model", model, "--operator", recording, "--out", f"out{draw.choice(WRITTEN)}"]


def _diagnose(draw: random.Random, seeds: Path) -> list[str]:
    model, recording = _replayed(draw, seeds, draw.choice(list(RECORDED)))
    return ["diagnose", recording, "--model", model, "--out", "out", "--jobs", "1", *_SHORT]


def _run_scenario(draw: random.Random, seeds: Path) -> list[str]:
    names = sorted(path.name for path in seeds.glob("setup*.yaml"))
    return ["run", _strange(draw, seeds, *names), "--seconds", "0.02", "--record", f"out{draw.choice(WRITTEN)}"]


def _run_operator(draw: random.Random, seeds: Path) -> list[str]:
    forms = ("contact.csv", "contact.npz", "contact.mcap", "motion.bag", "motion.db3")
    return ["run", "setup1", "--operator", _strange(draw, seeds, *forms), "--seconds", "0.02"]


def _trial(draw: random.Random, seeds: Path) -> list[str]:
    """The public recordings' folder; the first of them is strange, and all others are missing."""
    for name in ("emps", "silverbox", "bam_servo", "mr_damper", "falling_balls", "dvrk_palpation"):
        (Path("in") / name).mkdir(parents=True)
    _strange(draw, seeds, "public.npz", to="in/emps/train")
    if draw.random() < 0.5:
        _strange(draw, seeds, "public.npz", to="in/emps/test_pulses")
    return ["trial", "--real", "in", "--out", "out", "--jobs", "1", *_SHORT]


def _yaml(draw: random.Random, seeds: Path) -> int:
    """The loader, and what a scenario makes of its numbers."""
    path = _strange(draw, seeds, *sorted(path.name for path in seeds.glob("*.yaml")))
    if draw.random() < 0.5:
        key = draw.choice(("duration", "step", "seed", "operator.file", "to_operator.delay", "estimator", "a.b.c"))
        data = parse((seeds / "setup1.yaml").read_text(), "setup1.yaml")
        override(data, f"{key}={draw.choice((*NUMBERS, '!Recorded {file: x}', '[1, 2', '{a: 1', '*a'))}")
        fill(Scenario, data, "setup1.yaml")
    else:
        load_scenario(path, trust_library=True)  # or what it does not trust would hide all else
    return 0


def _cloud(draw: random.Random, seeds: Path) -> int:
    read_cloud(_strange(draw, seeds, "cloud.ply", "cloud.pcd", "cloud.xyz"))
    return 0


def _trace(draw: random.Random, seeds: Path) -> int:
    load_trace(_strange(draw, seeds, "trace.csv"))
    return 0


def _key(draw: random.Random, seeds: Path) -> int:
    name = _strange(draw, seeds, "link.key")
    os.chmod(name, 0o600)
    load_key(name)
    return 0


def _link(draw: random.Random, seeds: Path) -> int:
    """Two ends, between which some packets are strange: whoever made them, and by a peer that has the key."""
    now = [10**9]
    there, back = FaultyWire(lambda: now[0]), FaultyWire(lambda: now[0])

    def spoil(packet: bytes, sent: int) -> list[tuple[int, bytes]]:
        strange = [(sent, mutated(draw, packet, "", draw.choice(there.sent + back.sent)))]
        return [(sent, packet), *strange] if draw.random() < 0.5 else strange

    signals: dict[Role, LinkSignal] = {role: LinkSignal(role, np.zeros(6), motion=6) for role in (OPERATOR, TELEROBOT)}
    ends = ((OPERATOR, End(there, back)), (TELEROBOT, End(back, there)))
    options = LinkOptions(playout=draw.choice((0.0, 0.01)))
    links = [Link(role, signals, bytes(range(32)), end, options, clock=lambda: now[0]) for role, end in ends]
    shown = np.zeros(6)
    for tick in range(120):
        now[0] += 10**6
        there.fault = spoil if 5 < tick < 60 and draw.random() < 0.3 else at_once
        links[0].offer_cloud(Cloud(np.full((120, 3), 1e-3 * tick)))
        for link in links:
            link.exchange(1e-3 * tick, np.full(6, 1e-3 * tick), shown)
            if not (np.isfinite(shown).all() and np.isfinite(link.cloud.points()).all()):
                raise ValueError(f"shown: {shown}")
        if 10 < tick < 60:
            kind, body = (
                draw.choice((wire.DATA, wire.TRANSLATION, wire.BLOCK, wire.ALIVE)),
                draw.choice(there.sent)[44:],
            )
            links[0]._send(kind, mutated(draw, body, ""))
    if not all(link.alive or link.ended for link in links):
        raise ValueError(f"strange packets parted two ends: {[link.status for link in links]}")
    return 0


def _viewer(draw: random.Random, seeds: Path) -> int:
    """The live view's server: a strange request, and one that is answered as ever."""
    asyncio.run(_asked(draw, seeds))
    return 0


async def _asked(draw: random.Random, seeds: Path) -> None:
    ours, theirs = socket.socketpair()
    run = (await asyncio.open_connection(sock=ours))[1]
    shown = Server({"token": "0123", "page": "a page", "script": str(seeds / "setup1.yaml")}, run)
    shown.show({"x": {"type": "slider", "name": "x", "least": 0.0, "greatest": 1.0, "value": 0.5}})
    server, trouble = await asyncio.start_server(shown.answer, "127.0.0.1", 0), list[str]()
    asyncio.get_running_loop().set_exception_handler(lambda loop, context: trouble.append(str(context)))
    host, port = server.sockets[0].getsockname()
    shown.listen_at(port)
    head, body = f"HTTP/1.1\r\nHost: {host}:{port}\r\n", b'{"name": "x", "value": 0.25}'
    good = f"GET /0123/ {head}\r\n".encode()
    head += f"Origin: http://{host}:{port}\r\n"
    slid = f"POST /0123/sliders {head}Content-Length: {len(body)}\r\n\r\n".encode() + body
    for request in (mutated(draw, draw.choice((good, slid)), draw.choice(("", ".yaml", ".csv")), slid), good):
        reader, writer = await asyncio.open_connection(host, port)
        answer = b""
        with suppress(ConnectionError):  # it need not read a strange one to the end
            writer.write(request)
            writer.write_eof()
            answer = await asyncio.wait_for(reader.read(), 30.0)
        writer.close()
    server.close()
    theirs.close()
    run.close()
    if trouble or b" 200 " not in answer[:20]:
        raise ValueError(f"{answer[:80]!r} {trouble}")


TARGETS: dict[str, tuple[Target, int]] = {
    "convert": (_convert, 400),
    "simulate": (_simulate, 120),
    "diagnose": (_diagnose, 20),
    "run SCENARIO": (_run_scenario, 60),
    "run --operator": (_run_operator, 50),
    "trial --real": (_trial, 4),
    "scenario": (_yaml, 200),
    "cloud": (_cloud, 60),
    "trace": (_trace, 40),
    "key": (_key, 20),
    "link": (_link, 80),
    "viewer": (_viewer, 80),
}
"""What is tried, and how often."""


def fuzz(program: Program, seed: int = 0) -> Fuzz:
    """All of it."""
    return Fuzz(TARGETS, write_seeds, program, seed)
