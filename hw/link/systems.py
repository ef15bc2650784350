"""LeafSystems over a link, with the ports of the simulated network channels."""

import math

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.cloud import Cloud
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import LinkSignal
from mmt_drake.systems.leaf import LeafSystem


class LinkEnd(LeafSystem):
    """One end of a link between two machines.

    .. pydrake_system::

        name: LinkEnd
        input_ports:
        - sent
        - sent_age
        output_ports:
        - received
        - alive
        - age
        - status
        - clocks

    - `sent` (size): sampled once per period, goes to the peer.
    - `sent_age` (1): of it [s]; while it is infinite nothing is sent, and this side is as lost to the peer: an arm
      holds its place, and stops. Only there if asked for.
    - `received` (size): what the peer sent, or what is to be shown while it is lost. Read once per period: it is the
      network's delay and up to one period late.
    - `alive` (1): 1 while the peer is there, 0 while it is lost.
    - `age` (1): since the latest sample of a peer that hears us [s], as a supervisor watches it; infinite before the
      first, and after the peer's goodbye.
    - `status` (12): `mmt_drake.hw.link.link.STATUS`, times [s] and counts.
    - `clocks` (5): `mmt_drake.recording.signals.LINK_CLOCKS` [s]: time stamps by which two recordings are joined. Its
      `own` is of the instant at which it is read.

    The link is a driver: its socket and its peer stand in `self`, so that one link serves one run.

    Args:
        link: open, and connected if the run is not to begin without a peer.
        outward, inward: what this end sends and receives.
        period: between packets [s].
        aged: whether there is a port `sent_age`.
    """

    def __init__(
        self, link: Link, outward: LinkSignal, inward: LinkSignal, period: float = 1e-3, *, aged: bool = False
    ) -> None:
        super().__init__()
        self._link = link
        self.declare_inputs(sent=outward.size, sent_age=1 if aged else 0)
        self._period = period
        parts = {"received": inward.initial, "alive": np.zeros(1), "age": np.array([link.age]), "status": link.status}
        parts["clocks"] = link.clocks
        for name, first in parts.items():
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(first))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._exchange)

    def _exchange(self, context: Context, state: DiscreteValues) -> None:
        sent, age = self.inputs_at(context)
        believed = age is None or math.isfinite(age[0])
        self._link.exchange(context.get_time(), sent if believed else None, state.get_mutable_value(0))
        state.get_mutable_value(1)[0] = self._link.status[0]
        state.get_mutable_value(2)[0] = self._link.age
        state.get_mutable_value(3)[:] = self._link.status
        clocks = state.get_mutable_value(4)
        clocks[:] = self._link.clocks
        clocks[0] += self._period  # a state is read a period after it was made


class CloudToLink(LeafSystem):
    """Hands surfaces to a link.

    .. pydrake_system::

        name: CloudToLink
        input_ports:
        - sent

    - `sent` (abstract, `Cloud`): sampled once per period; the link sends it thinned, and at its own rate.

    Args:
        link: an open one.
        period: between frames [s].
    """

    def __init__(self, link: Link, period: float) -> None:
        super().__init__()
        self._link = link
        self._sent = self.DeclareAbstractInputPort("sent", AbstractValue.Make(Cloud.empty()))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._offer)

    def _offer(self, context: Context, state: DiscreteValues) -> None:
        self._link.offer_cloud(self._sent.Eval(context))


class CloudFromLink(LeafSystem):
    """Shows the surface that came over a link.

    .. pydrake_system::

        name: CloudFromLink
        output_ports:
        - received

    - `received` (abstract, `Cloud`): the newest that is complete, read once per period; empty before the first, and
      while the peer is lost: what is not there any more is not felt.

    Args:
        link: an open one.
        period: between frames [s].
    """

    def __init__(self, link: Link, period: float) -> None:
        super().__init__()
        self._link = link
        state = self.DeclareAbstractState(Value(Cloud.empty()))
        self.DeclareStateOutputPort("received", state)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._read)

    def _read(self, context: Context, state: State) -> None:
        state.get_mutable_abstract_state(0).set_value(self._link.cloud if self._link.alive else Cloud.empty())
