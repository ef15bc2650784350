"""Networks: what they do to a stream of packets."""

from mmt_drake.network.config import ChannelConfig

__all__ = ["ChannelConfig"]
