"""Browsers that misbehave, played by a bare socket."""

from __future__ import annotations

import base64
import os
import socket
import time

from pydrake.geometry import Meshcat


def browser_that_never_reads(meshcat: Meshcat) -> socket.socket:
    """A connection to Meshcat's WebSocket (RFC 6455) that takes in nothing after the handshake."""
    before = meshcat.GetNumActiveConnections()
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect(("127.0.0.1", meshcat.port()))
    key = base64.b64encode(os.urandom(16)).decode()
    connection.sendall(
        f"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    deadline = time.monotonic() + 20.0
    while meshcat.GetNumActiveConnections() == before:
        assert time.monotonic() < deadline, "Meshcat did not accept the connection"
        time.sleep(0.01)
    return connection
