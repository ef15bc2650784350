"""The process behind `page_server`: `serve_page.py LENGTH`, the page on standard input.

It prints its port, ends where its input ends, and needs nothing but Python's own library.
"""

from __future__ import annotations

import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer


def main() -> None:
    """Serve until standard input ends."""
    body = sys.stdin.buffer.read(int(sys.argv[1]))

    class OnePage(BaseHTTPRequestHandler):
        """The page at `/`, nothing else."""

        def do_GET(self) -> None:
            """Answer a browser."""
            if self.path != "/":
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *message: object) -> None:
            """Say nothing: the terminal is the run's."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), OnePage)
    server.daemon_threads = True
    print(server.server_port, flush=True)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    sys.stdin.buffer.read()
    server.shutdown()


if __name__ == "__main__":
    main()
