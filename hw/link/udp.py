"""The socket under a link."""

import ipaddress
import socket
from dataclasses import dataclass
from typing import Any, Self

from mmt_drake.errors import BadInput

DEFAULT_PORTS = {"operator": 47310, "telerobot": 47311}
"""Where each side listens by default."""

_LONGEST = 2048  # longer ones are cut off and so fail to authenticate
BUFFER = 1 << 18
"""Buffer for incoming packets that is asked of the kernel [bytes]."""


@dataclass(frozen=True)
class Address:
    """A host and a port.

    Attributes:
        host: name or address.
        port: 0 lets the system choose, for listening.
    """

    host: str
    port: int

    @classmethod
    def parse(cls, text: str, option: str, port: int) -> Self:
        """From `HOST`, `HOST:PORT` or `[IPv6]:PORT`.

        Raises:
            BadInput: it has another form; `option` says where it was given.
        """
        host, number = text, str(port)
        if text.startswith("["):
            host, _, rest = text[1:].partition("]")
            number = rest[1:] if rest.startswith(":") else (str(port) if not rest else "")
        elif text.count(":") == 1:
            host, _, number = text.partition(":")
        if not host or not (number.isascii() and number.isdigit() and 0 <= int(number) < 65536):
            raise BadInput(option, found=text or "nothing", expected="HOST or HOST:PORT")
        return cls(host, int(number))

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


class UdpSocket:
    """A socket that never blocks and hears its peer alone.

    The kernel drops what comes from other addresses. That keeps strangers from costing time; who the peer is, is for
    the cipher to say.

    Args:
        listen: where.
        peer: with whom.

    Raises:
        BadInput: an address is unknown, taken, or of no use together.
    """

    def __init__(self, listen: Address, peer: Address) -> None:
        family, theirs = _resolved(peer, "--peer")
        if peer.port == 0:
            raise BadInput("--peer", found=str(peer), expected="HOST:PORT, the port above 0")
        ours = _resolved(listen, "--listen", family)[1]
        if _is_loopback(ours[0]) and not _is_loopback(theirs[0]):
            expected = f"an address of this machine that {peer.host} can reach: --listen HOST:PORT"
            raise BadInput("--listen", found=f"{listen}, this machine alone", expected=expected)
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
            self._socket.bind(ours)
            self._socket.connect(theirs)
        except OSError as error:
            self._socket.close()
            raise BadInput("--listen", found=f"{listen}: {error.strerror}", expected="a free address") from None

    @property
    def port(self) -> int:
        """Where it listens."""
        port: int = self._socket.getsockname()[1]
        return port

    def send(self, datagram: bytes) -> bool:
        """Send, or drop if the network does not take it now."""
        try:
            self._socket.send(datagram)
        except OSError:
            # Full, unreachable, nobody there: the same to us as a packet lost on its way.
            return False
        return True

    def receive(self) -> bytes | None:
        """The next datagram that has come; None if there is none."""
        for _ in range(4):
            try:
                return self._socket.recv(_LONGEST)
            except BlockingIOError:
                return None
            except OSError:
                continue  # reported by the network: a packet that we sent: nobody listened, say
        return None

    def close(self) -> None:
        """Give the address back."""
        self._socket.close()


def _resolved(address: Address, option: str, family: int = 0) -> tuple[int, tuple[Any, ...]]:
    try:
        found = socket.getaddrinfo(address.host, address.port, family=family, type=socket.SOCK_DGRAM)
    except OSError as error:
        raise BadInput(option, found=f"{address.host}: {error.strerror}", expected="a host that can be found") from None
    return found[0][0], found[0][4]


def _is_loopback(host: str) -> bool:
    return ipaddress.ip_address(host.partition("%")[0]).is_loopback
