"""The network between two machines: operator's side and telerobot's side, over UDP, encrypted and authenticated.

`keys` (the shared key), `wire` (what stands in a packet), `replay` (which packets are new), `endpoint` (who the peer
is: handshake, sessions, freshness), `peer_clock` (the peer's time in ours), `samples` (what is shown of what arrived),
`clouds` (surfaces in many small packets), `udp` (the socket), `link` (all of these as one), `systems` (LeafSystems with
the ports of the simulated network channels).

Both sides hold the same 32-byte key. Each start draws a fresh number; the keys of a session are derived from the
numbers of both sides (HKDF-SHA256), so nothing recorded in an earlier session, or in the other direction, passes.
Packets are sealed by ChaCha20-Poly1305 under their sequence number; within a session a number is taken once.
"""
