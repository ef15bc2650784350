"""Takes back what a device that has stopped would go on to say."""

from mmt_drake.systems.leaf import LeafSystem


class WhileWell(LeafSystem):
    """Hands a number on while a device is well, and 0 while its driver reports a fault.

    What an arm last touched is no longer there once it has stopped: nobody is to feel it.

    .. pydrake_system::

        name: WhileWell
        input_ports:
        - signal
        - device
        output_ports:
        - signal

    - `signal` (1): as it comes and, as an output, as it goes on; direct feedthrough.
    - `device` (3): as a driver tells of itself: fault code, time of the latest reading [s], and a flag.
    """

    def __init__(self) -> None:
        super().__init__()
        self.declare_inputs(signal=1, device=3)
        self.declare_function("signal", 1, lambda t, signal, device: signal if device[0] == 0.0 else 0.0)
