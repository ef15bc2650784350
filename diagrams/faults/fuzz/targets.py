"""Everything that reads what comes from outside: the commands' files, the loaders beneath, packets."""

from __future__ import annotations

import asyncio
import os
import random
import socket
from contextlib import suppress
from pathlib import Path

import numpy as np

from mmt_drake.cloud import Cloud
from mmt_drake.cloud.files import read_cloud
from mmt_drake.diagrams.faults.fuzz.harness import Fuzz, Program, Target
from mmt_drake.diagrams.faults.fuzz.mutations import NUMBERS, mutated
from mmt_drake.diagrams.faults.fuzz.seeds import RECORDED, write_seeds
from mmt_drake.diagrams.faults.link.wires import End, FaultyWire, at_once
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.hw.link import OPERATOR, TELEROBOT, Link, LinkOptions, wire
from mmt_drake.hw.link.keys import load_key
from mmt_drake.hw.link.options import Role, Signal
from mmt_drake.recording.files import WRITTEN
from mmt_drake.typed_yaml import fill, override, parse
from mmt_drake.viewer.serve import Server


def _strange(draw: random.Random, seeds: Path, *names: str, to: str = "in") -> str:
    """One of these valid files, mutated, in the present folder; its name there."""
    source = seeds / draw.choice(names)
    other = draw.choice(sorted(path for path in seeds.iterdir() if path.is_file()))
    target = Path(f"{to}{source.suffix}")
    target.write_bytes(mutated(draw, source.read_bytes(), source.suffix, other.read_bytes()))
    return str(target)


def _convert(draw: random.Random, seeds: Path) -> list[str]:
    forms = [f"{name}{ending}" for name in ("contact", "axis", "driven") for ending in WRITTEN]
    there = [
        *filter(lambda form: (seeds / form).exists(), forms),
        "contact.mcap",
        "public.npz",
        "motion.bag",
        "motion.db3",
    ]
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
    return ["diagnose", recording, "--model", model, "--out", "out", "--jobs", "1"]


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
    return ["trial", "--real", "in", "--out", "out", "--jobs", "1"]


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

    signals: dict[Role, Signal] = {role: Signal(role, np.zeros(6), motion=6) for role in (OPERATOR, TELEROBOT)}
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
            kind, body = draw.choice((wire.DATA, wire.PLACE, wire.BLOCK, wire.ALIVE)), draw.choice(there.sent)[44:]
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
    "key": (_key, 20),
    "link": (_link, 80),
    "viewer": (_viewer, 80),
}
"""What is tried, and how often."""


def fuzz(program: Program, seed: int = 0) -> Fuzz:
    """All of it."""
    return Fuzz(TARGETS, write_seeds, program, seed, searching=frozenset({"diagnose", "trial --real"}))
