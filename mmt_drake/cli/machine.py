"""The machine that `doctor` looks at: its devices, its readiness for real time, its graphics.

Nothing is opened, moved or changed: devices and the kernel are read from /sys and /proc, and OpenGL is tried in a
process of its own.
"""

import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

Status = Literal["ok", "gap", "optional"]

_LATE_US = 200.0  # lateness of a 1 ms sleep up to which a machine counts as calm
_TIMER_SLACK_NS = 1000
_IDLE_US = 50  # to wake from an idle state; a paced loop spins for 200 us, which covers that
_BUSY = 0.5  # share of the processors in use up to which a machine counts as calm
_REALTIME_PRIORITY = 80


@dataclass(frozen=True)
class Check:
    """One thing that was looked at.

    Attributes:
        group: heading it stands under.
        name: what was looked at.
        status: `ok`; `gap`, something to mend; `optional`, missed only by those who use that hardware or data.
        found: what is there, with its unit.
        advice: what to do about it; empty when there is nothing to do.
    """

    group: str
    name: str
    status: Status
    found: str
    advice: str = ""


@dataclass(frozen=True)
class Machine:
    """Where the checks look; another root lets tests show them another machine.

    Attributes:
        root: the folder that holds sys, proc, dev and usr.
        environ: environment variables.
    """

    root: Path = Path("/")
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)

    def read(self, path: str) -> str | None:
        """Text of a file below the root, stripped; None when it is not there."""
        try:
            return (self.root / path).read_text().strip()
        except OSError:
            return None


def devices(machine: Machine) -> Iterator[Check]:
    """Haptic devices and cameras on USB, and the cable that an arm would hang on."""
    group = "devices"
    usb = [
        (entry, (machine.read(f"{entry}/idVendor") or "").lower(), machine.read(f"{entry}/product") or "")
        for entry in sorted((machine.root / "sys/bus/usb/devices").glob("*"))
    ]
    for name, present in [
        ("Force Dimension device", [(e, p) for e, vendor, p in usb if vendor == "1451"]),
        ("RealSense camera", [(e, p) for e, vendor, p in usb if vendor == "8086" and "RealSense" in p]),
    ]:
        for entry, product in present:
            bus, number = (int(machine.read(f"{entry}/{key}") or 0) for key in ("busnum", "devnum"))
            node = machine.root / f"dev/bus/usb/{bus:03d}/{number:03d}"
            if os.access(node, os.R_OK | os.W_OK):
                yield Check(group, name, "ok", f"{product or 'unnamed'} at {node}")
            else:
                advice = "install the vendor's udev rules, then plug it in again"
                yield Check(group, name, "gap", f"{product or 'unnamed'} at {node}, no permission", advice)
        if not present:
            yield Check(group, name, "optional", "none on USB", "plug it in and switch it on, if you use one")
    wired = [
        entry.name
        for entry in sorted((machine.root / "sys/class/net").glob("*"))
        if entry.name != "lo" and not (entry / "wireless").exists() and machine.read(f"{entry}/operstate") == "up"
    ]
    if wired:
        yield Check(group, "wired network", "ok", ", ".join(wired))
    else:
        advice = "connect a Franka arm's control box by cable: wireless loses its 1 kHz packets"
        yield Check(group, "wired network", "optional", "no cable connected", advice)


def real_time(machine: Machine) -> Iterator[Check]:
    """Kernel, limits and clock, and how late a 1 ms sleep really is."""
    group = "real time"
    version = machine.read("proc/version") or "unknown"
    if machine.read("sys/kernel/realtime") == "1" or "PREEMPT_RT" in version:
        yield Check(group, "kernel", "ok", "PREEMPT_RT")
    else:
        advice = "for hardware: apt-get install linux-image-rt-amd64 (Debian), pro enable realtime-kernel (Ubuntu)"
        yield Check(group, "kernel", "optional", "no PREEMPT_RT", advice)
    yield _limit(group, "real-time priority", resource.RLIMIT_RTPRIO, _REALTIME_PRIORITY, "rtprio 99")
    yield _limit(group, "locked memory", resource.RLIMIT_MEMLOCK, resource.RLIM_INFINITY, "memlock unlimited")
    governors = {
        machine.read(str(path)) for path in machine.root.glob("sys/devices/system/cpu/cpu*/cpufreq/scaling_governor")
    }
    if governors <= {"performance"}:
        yield Check(group, "CPU governor", "ok", "performance" if governors else "the kernel scales no frequency")
    else:
        advice = "cpupower frequency-set --governor performance"
        yield Check(group, "CPU governor", "optional", ", ".join(sorted(filter(None, governors))), advice)
    yield from _processors(machine, group)
    clock = machine.read("sys/devices/system/clocksource/clocksource0/current_clocksource")
    if clock in ("tsc", "arch_sys_counter", "kvm-clock"):
        yield Check(group, "clock source", "ok", clock)
    elif clock is None:
        yield Check(
            group, "clock source", "optional", "unknown", "/sys cannot be read here; look outside the container"
        )
    else:
        advice = "reading this clock is slow; boot with clocksource=tsc if the CPU allows it"
        yield Check(group, "clock source", "gap", clock, advice)
    slack = int(machine.read("proc/self/timerslack_ns") or 0)
    if slack <= _TIMER_SLACK_NS:
        yield Check(group, "timer slack", "ok", f"{slack} ns")
    else:
        advice = "a paced run sets its own to 1 ns; nothing to do unless you pace by other means"
        yield Check(group, "timer slack", "optional", f"{slack} ns", advice)
    late = _sleep_lateness()
    found = f"median {statistics.median(late):.0f} us, worst of {len(late)} {max(late):.0f} us"
    calm = statistics.quantiles(late, n=100)[98] <= _LATE_US
    advice = "" if calm else "close what else is running; a paced run at 1 kHz would start many ticks late"
    yield Check(group, "lateness of a 1 ms sleep", "ok" if calm else "optional", found, advice)


def _processors(machine: Machine, group: str) -> Iterator[Check]:
    """How deep they sleep, whether one is kept for the fast path, and what else they do."""
    states = machine.root.glob("sys/devices/system/cpu/cpu0/cpuidle/state*/latency")
    deepest = max((int(machine.read(str(state.relative_to(machine.root))) or 0) for state in states), default=None)
    if deepest is None:
        yield Check(group, "idle states", "ok", "none that the kernel chooses")
    elif deepest <= _IDLE_US:
        yield Check(group, "idle states", "ok", f"awake within {deepest} us")
    else:
        advice = "for hardware: cpupower idle-set --disable-by-latency 20"
        yield Check(group, "idle states", "optional", f"up to {deepest} us to wake from the deepest", advice)
    apart = machine.read("sys/devices/system/cpu/isolated")
    if apart:
        yield Check(group, "processor set apart", "ok", f"{apart}; run --realtime --cpu N uses one")
    else:
        advice = "for hardware: boot with isolcpus=N nohz_full=N and give run --realtime --cpu N"
        yield Check(group, "processor set apart", "optional", "none", advice)
    load = machine.read("proc/loadavg")
    if load is not None:
        busy, processors = float(load.split()[0]), os.cpu_count() or 1
        calm = busy <= _BUSY * processors
        found = f"{busy:g} threads on {processors} processors wanted to run in the last minute"
        advice = "" if calm else "close what else is running before a paced run"
        yield Check(group, "load", "ok" if calm else "optional", found, advice)


def _limit(group: str, name: str, kind: int, wanted: int, line: str) -> Check:
    _, hard = resource.getrlimit(kind)
    unlimited = resource.RLIM_INFINITY
    in_unit = f"{hard / 1e6:.0f} MB" if kind == resource.RLIMIT_MEMLOCK else str(hard)
    found = f"at most {'unlimited' if hard == unlimited else in_unit}"
    if hard == unlimited or (wanted != unlimited and hard >= wanted):
        return Check(group, name, "ok", found)
    advice = (
        f"for hardware: put '@realtime - {line}' into /etc/security/limits.d/realtime.conf, join that group, log in"
    )
    return Check(group, name, "optional", found, advice)


def _sleep_lateness(count: int = 200, period: float = 1e-3) -> list[float]:
    """How much later than asked `time.sleep` returns, `count` times [us]."""
    late = []
    for _ in range(count):
        start = time.perf_counter()
        time.sleep(period)
        late.append((time.perf_counter() - start - period) * 1e6)
    return late


_EGL_PROBE = """
import ctypes
egl = ctypes.CDLL("libEGL.so.1")
egl.eglGetPlatformDisplay.restype = ctypes.c_void_p
egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
egl.eglQueryString.restype = ctypes.c_char_p
egl.eglQueryString.argtypes = [ctypes.c_void_p, ctypes.c_int]
SURFACELESS_MESA, VENDOR, VERSION = 0x31DD, 0x3053, 0x3054
display = egl.eglGetPlatformDisplay(SURFACELESS_MESA, None, None)
assert display and egl.eglInitialize(display, None, None)
print("EGL", egl.eglQueryString(display, VERSION).decode(), "by", egl.eglQueryString(display, VENDOR).decode())
"""


def graphics() -> Iterator[Check]:
    """Whether a camera can be rendered with no screen. Tried in another process, which a broken driver may kill."""
    probe = subprocess.run([sys.executable, "-c", _EGL_PROBE], capture_output=True, text=True, timeout=30, check=False)
    if probe.returncode == 0:
        yield Check("graphics", "OpenGL without a screen", "ok", probe.stdout.strip())
    else:
        reason = (probe.stderr.strip().splitlines() or [f"killed by signal {-probe.returncode}"])[-1]
        advice = "for simulated cameras: apt-get install libegl1 libgl1-mesa-dri"
        yield Check("graphics", "OpenGL without a screen", "gap", reason, advice)
