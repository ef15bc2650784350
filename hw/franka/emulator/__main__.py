"""`python -m mmt_drake.hw.franka.emulator` serves a simulated arm on loopback until its input ends."""

import json
import queue
import sys
import threading
import time
from typing import Any

_TICK = 1e-3  # [s]


def main() -> int:
    """Say the address, then answer one line of JSON with one."""
    from mmt_drake.hw.franka.emulator.server import Emulator, World

    world = World()
    with Emulator(world) as emulator:
        requests: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        threading.Thread(target=_read, args=(requests,), daemon=True).start()
        print(json.dumps({"address": emulator.server.hostname}), flush=True)
        until = time.monotonic()
        while True:
            until = max(
                until + _TICK, time.monotonic()
            )  # late ticks are not made up for: the far side could not follow
            emulator.tick(until)
            while not requests.empty():
                request = requests.get()
                if request is None:
                    return 0
                if request.get("reset"):
                    emulator.reset()
                for name, value in request.get("set", {}).items():
                    if not hasattr(world, name):
                        raise KeyError(name)
                    setattr(world, name, value)
                print(json.dumps(emulator.state()), flush=True)


def _read(requests: queue.SimpleQueue[dict[str, Any] | None]) -> None:
    for line in sys.stdin:
        requests.put(json.loads(line))
    requests.put(None)


if __name__ == "__main__":
    raise SystemExit(main())
