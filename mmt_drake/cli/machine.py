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


def judged(good: bool, group: str, name: str, found: str, advice: str, otherwise: Status = "optional") -> Check:
    """A check that is `ok` where it is good, and else says what to do."""
    return Check(group, name, "ok", found) if good else Check(group, name, otherwise, found, advice)


@dataclass(frozen=True)
class Machine:
    """The machine at which the checks look; another root lets tests show them another one.

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

    def interfaces(self) -> list[Path]:
        """The folders of the network's interfaces that are up, without loopback."""
        found = sorted((self.root / "sys/class/net").glob("*"))
        return [entry for entry in found if entry.name != "lo" and self.read(f"{entry}/operstate") == "up"]


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
            may_open = os.access(node, os.R_OK | os.W_OK)
            found = f"{product or 'unnamed'} at {node}{'' if may_open else ', no permission'}"
            advice = "install the vendor's udev rules, then plug it in again"
            yield judged(may_open, group, name, found, advice, "gap")
        if not present:
            yield Check(group, name, "optional", "none on USB", "plug it in and switch it on, if you use one")
    wired = ", ".join(entry.name for entry in machine.interfaces() if not (entry / "wireless").exists())
    advice = "connect a Franka arm's control box by cable: wireless loses its 1 kHz packets"
    yield judged(bool(wired), group, "wired network", wired or "no cable connected", advice)


def real_time(machine: Machine) -> Iterator[Check]:
    """Kernel, limits and clock, and how late a 1 ms sleep really is."""
    group = "real time"
    patched = machine.read("sys/kernel/realtime") == "1" or "PREEMPT_RT" in (machine.read("proc/version") or "")
    advice = "for hardware: apt-get install linux-image-rt-amd64 (Debian), pro enable realtime-kernel (Ubuntu)"
    yield judged(patched, group, "kernel", f"{'' if patched else 'no '}PREEMPT_RT", advice)
    yield _limit(group, "real-time priority", resource.RLIMIT_RTPRIO, _REALTIME_PRIORITY, "rtprio 99")
    yield _limit(group, "locked memory", resource.RLIMIT_MEMLOCK, resource.RLIM_INFINITY, "memlock unlimited")
    paths = machine.root.glob("sys/devices/system/cpu/cpu*/cpufreq/scaling_governor")
    governors = {machine.read(str(path)) for path in paths}
    found = ", ".join(sorted(filter(None, governors))) if governors else "the kernel scales no frequency"
    advice = "cpupower frequency-set --governor performance"
    yield judged(governors <= {"performance"}, group, "CPU governor", found, advice)
    yield from _processors(machine, group)
    clock = machine.read("sys/devices/system/clocksource/clocksource0/current_clocksource")
    if clock is None:
        advice = "/sys cannot be read here; look outside the container"
        yield Check(group, "clock source", "optional", "unknown", advice)
    else:
        advice = "reading this clock is slow; boot with clocksource=tsc if the CPU allows it"
        quick = clock in ("tsc", "arch_sys_counter", "kvm-clock")
        yield judged(quick, group, "clock source", clock, advice, "gap")
    slack = int(machine.read("proc/self/timerslack_ns") or 0)
    advice = "a paced run sets its own to 1 ns; nothing to do unless you pace by other means"
    yield judged(slack <= _TIMER_SLACK_NS, group, "timer slack", f"{slack} ns", advice)
    late = _sleep_lateness()
    found = f"median {statistics.median(late):.0f} us, worst of {len(late)} {max(late):.0f} us"
    advice = "close what else is running; a paced run at 1 kHz would start many ticks late"
    yield judged(percentile_99(late) <= _LATE_US, group, "lateness of a 1 ms sleep", found, advice)


def percentile_99(values: list[float]) -> float:
    """The 99th percentile of numbers; of one, that one."""
    return statistics.quantiles(values, n=100)[98] if len(values) > 1 else values[0]


def _processors(machine: Machine, group: str) -> Iterator[Check]:
    """Processors: how deep they sleep, whether one is kept for the fast path, and what else they do."""
    states = machine.root.glob("sys/devices/system/cpu/cpu0/cpuidle/state*/latency")
    deepest = max((int(machine.read(str(state)) or 0) for state in states), default=None)
    if deepest is None:
        yield Check(group, "idle states", "ok", "none that the kernel chooses")
    else:
        quick = deepest <= _IDLE_US
        found = f"awake within {deepest} us" if quick else f"up to {deepest} us to wake from the deepest"
        yield judged(quick, group, "idle states", found, "for hardware: cpupower idle-set --disable-by-latency 20")
    apart = machine.read("sys/devices/system/cpu/isolated")
    found = f"{apart}; run --realtime --cpu N uses one" if apart else "none"
    advice = "for hardware: boot with isolcpus=N nohz_full=N and give run --realtime --cpu N"
    yield judged(bool(apart), group, "processor set apart", found, advice)
    load = machine.read("proc/loadavg")
    if load is not None:
        busy, processors = float(load.split()[0]), os.cpu_count() or 1
        found = f"{busy:g} threads on {processors} processors wanted to run in the last minute"
        advice = "close what else is running before a paced run"
        yield judged(busy <= _BUSY * processors, group, "load", found, advice)


def _limit(group: str, name: str, kind: int, wanted: int, line: str) -> Check:
    _, hard = resource.getrlimit(kind)
    unlimited = resource.RLIM_INFINITY
    in_unit = f"{hard / 1e6:.0f} MB" if kind == resource.RLIMIT_MEMLOCK else str(hard)
    found = f"at most {'unlimited' if hard == unlimited else in_unit}"
    enough = hard == unlimited or (wanted != unlimited and hard >= wanted)
    where = "/etc/security/limits.d/realtime.conf"
    return judged(
        enough, group, name, found, f"for hardware: put '@realtime - {line}' into {where}, join that group, log in"
    )


def _sleep_lateness() -> list[float]:
    """Lateness of `time.sleep` after 1 ms, 200 times [us]."""
    late = []
    for _ in range(200):
        start = time.perf_counter()
        time.sleep(1e-3)
        late.append((time.perf_counter() - start - 1e-3) * 1e6)
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
    """Rendering of a camera with no screen. Tried in another process, which a broken driver may kill."""
    probe = subprocess.run([sys.executable, "-c", _EGL_PROBE], capture_output=True, text=True, timeout=30, check=False)
    renders, said = probe.returncode == 0, probe.stdout.strip()
    if not renders:
        said = (probe.stderr.strip().splitlines() or [f"killed by signal {-probe.returncode}"])[-1]
    advice = "for simulated cameras: apt-get install libegl1 libgl1-mesa-dri"
    yield judged(renders, "graphics", "OpenGL without a screen", said, advice, "gap")
