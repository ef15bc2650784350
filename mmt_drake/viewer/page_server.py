"""Serves one page to the browsers of this machine, from a process of its own.

A thread of the run would take the interpreter from it whenever somebody loads the page. The process ends with the run,
however that ends: it waits for the end of its standard input, which the run holds open.
"""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from mmt_drake.closing import Closing

_READY_WITHIN = 20.0  # [s]


class PageServer(Closing):
    """A page on a free port of the loopback interface.

    Args:
        page: HTML.

    Raises:
        OSError: the process could not be started, or no port be had.
    """

    def __init__(self, page: str) -> None:
        body = page.encode()
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(Path(__file__).with_name("serve_page.py")), str(len(body))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            process_group=0,  # Ctrl-C is for the run
        )
        page_in, port_out = self._process.stdin, self._process.stdout
        assert page_in is not None and port_out is not None
        self._pipes = page_in, port_out
        with suppress(BrokenPipeError):  # it has ended; what it says, or does not, tells
            page_in.write(body)
            page_in.flush()
        port = port_out.readline().strip()
        if not port:
            self.close()
            raise OSError(f"the server of the page ended with status {self._process.returncode}")
        self.url = f"http://localhost:{int(port)}/"

    def close(self) -> None:
        """End the process. A second call does nothing."""
        for pipe in self._pipes:
            with suppress(BrokenPipeError):  # it has ended already
                pipe.close()
        self._process.wait(_READY_WITHIN)
