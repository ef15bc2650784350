"""Point clouds of a surface, and the proxy that does not pass through them."""

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.plane import plane
from mmt_drake.cloud.proxy import ProxySettings, contact_offset

__all__ = ["Cloud", "ProxySettings", "contact_offset", "plane"]
