"""Chromium without a window, driven over a pipe: its DevTools protocol, with nothing but Python's own library."""

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

NAMES = ("chrome-headless-shell", "chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
PATIENCE = 60.0  # [s]: a loaded machine that draws without graphics hardware

_FLAGS = (
    "--headless=new",
    "--no-sandbox",  # it sees pages of this test alone, and containers permit none
    "--remote-debugging-pipe",
    "--use-angle=swiftshader",  # WebGL by the processor
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--no-default-browser-check",
    "--mute-audio",
)
_TO_BROWSER, _FROM_BROWSER = 3, 4  # descriptors of --remote-debugging-pipe


def find_chromium() -> str | None:
    """Its program: what MMT_CHROMIUM names, or one of `NAMES` on the path."""
    return os.environ.get("MMT_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)


class Chromium:
    """One browser with one tab.

    Args:
        program: see `find_chromium`.
        size: of its window [px].

    Attributes:
        requested: addresses that its pages asked for.
        complaints: exceptions and errors of its pages.
    """

    def __init__(self, program: str, size: tuple[int, int] = (1100, 620)) -> None:
        self.requested: list[str] = []
        self.complaints: list[str] = []
        self._contexts: dict[int, str] = {}  # of scripts -> where the page is from
        self._profile = tempfile.TemporaryDirectory(prefix="chromium-", ignore_cleanup_errors=True)
        reads, self._write = os.pipe()
        self._read, writes = os.pipe()

        def connect() -> None:  # in the child; first out of the way of each other's numbers
            from_here, to_here = os.dup(reads), os.dup(writes)
            os.dup2(from_here, _TO_BROWSER)
            os.dup2(to_here, _FROM_BROWSER)

        self._process = subprocess.Popen(
            [
                program,
                *_FLAGS,
                f"--window-size={size[0]},{size[1]}",
                f"--user-data-dir={self._profile.name}",
                "about:blank",
            ],
            preexec_fn=connect,
            close_fds=False,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            process_group=0,  # to be killed with all its children
        )
        os.close(reads)
        os.close(writes)
        self._received = b""
        self._number = 0
        self._session: str | None = None
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Page", "Log", "Network"):
            self._call(f"{domain}.enable")

    def open(self, url: str) -> None:
        """Go to a page."""
        self._call("Page.navigate", url=url)

    def evaluate(self, script: str, origin: str) -> Any:
        """The value of a script in the page, or the frame of it, that comes from an address; None if it fails."""
        self._call("Runtime.getIsolateId")  # takes in what has happened meanwhile
        contexts = [number for number, source in self._contexts.items() if source == origin.rstrip("/")]
        if not contexts:
            return None
        answer = self._call("Runtime.evaluate", expression=script, contextId=contexts[-1], returnByValue=True)
        return answer.get("result", {}).get("value")

    def wait_for(self, script: str, origin: str, while_waiting: Callable[[], object] = lambda: None) -> Any:
        """The value of a script once that is true.

        Raises:
            TimeoutError: it does not come true.
        """
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            if value := self.evaluate(script, origin):
                return value
            while_waiting()
            time.sleep(0.1)
        raise TimeoutError(f"{script!r} in {origin} does not come true; complaints: {self.complaints}")

    def narrow(self, width: int, height: int) -> None:
        """Show pages as on a screen of this size [px], which may be a phone's."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self._call("Emulation.setDeviceMetricsOverride", **size)

    def click(self, x: float, y: float) -> None:
        """Press and release the left button at a place of the page [px]."""
        for kind in ("mousePressed", "mouseReleased"):
            self._call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def picture(self, file: Path) -> None:
        """Write what the tab shows, as JPEG or PNG by the ending of the file's name."""
        how: dict[str, Any] = {"format": "png"} if file.suffix == ".png" else {"format": "jpeg", "quality": 80}
        shown = self._call("Page.captureScreenshot", **how)
        file.write_bytes(base64.b64decode(shown["data"]))

    def kill(self) -> None:
        """End it at once, as the kernel does when memory is short. A second call does nothing."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
            os.close(self._write)
            os.close(self._read)
            self._profile.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.kill()

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self._number:
                if "error" in answer:
                    return {"error": answer["error"]}
                return dict(answer["result"])
            self._take_down(answer.get("method"), answer.get("params", {}))

    def _message(self) -> dict[str, Any]:
        while b"\0" not in self._received:
            if not select.select([self._read], [], [], PATIENCE)[0]:
                raise TimeoutError("Chromium does not answer")
            some = os.read(self._read, 1 << 16)
            if not some:
                raise EOFError("Chromium has ended")
            self._received += some
        message, _, self._received = self._received.partition(b"\0")
        return dict(json.loads(message))

    def _take_down(self, event: str | None, told: dict[str, Any]) -> None:
        if event == "Runtime.executionContextCreated":
            self._contexts[told["context"]["id"]] = told["context"]["origin"].rstrip("/")
        elif event == "Runtime.executionContextDestroyed":
            self._contexts.pop(told["executionContextId"], None)
        elif event == "Runtime.executionContextsCleared":
            self._contexts.clear()
        elif event == "Network.requestWillBeSent":
            self.requested.append(told["request"]["url"])
        elif event == "Network.webSocketCreated":
            self.requested.append(told["url"])
        elif event == "Runtime.exceptionThrown":
            self.complaints.append(str(told["exceptionDetails"])[:400])
        elif event == "Log.entryAdded" and told["entry"]["level"] == "error":
            self.complaints.append(str(told["entry"])[:400])
