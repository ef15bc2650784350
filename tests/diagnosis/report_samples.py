"""What reports are made of in tests: evidence, and a diagnosis of each verdict."""

from dataclasses import replace

import numpy as np
from scipy.signal import welch

from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.mismatch import BlockShare, Dependence, Mismatch
from mmt_drake.diagnosis.tell.evidence import Curve, Evidence, Series, Spectrum
from mmt_drake.diagnosis.tell.result import (
    Alternative,
    Candidate,
    Diagnosis,
    EffectParameter,
    Fit,
    FittedParameter,
    HeldoutNrmse,
    NamedEffect,
)

NOISE = 0.02
RATE = 500.0
HELDOUT = ((6.0, 9.0), (18.0, 21.0))
LEARNED = (-0.7, -0.9, 0.1, 0.8, 0.6)
TABLE = NamedEffect(
    "tabulated_force",
    "tabulated_force",
    "friction",
    None,
    {
        "of": EffectParameter("sliding_velocity", ""),
        "at": EffectParameter((-0.2, -0.1, 0.0, 0.1, 0.2), "m/s"),
        "value": EffectParameter(
            (-0.7, -0.9, 0.1, 0.8, 0.6), "N", ((-0.8, -1.0, 0.0, 0.7, 0.5), (-0.6, -0.8, 0.2, 0.9, 0.7))
        ),
    },
)


def evidence_with_friction(seconds: float = 30.0) -> Evidence:
    """A body dragged with 60 N s/m and 0.8 N of friction, which the nominal and the refitted model lack."""
    noise = np.random.default_rng(7)
    time = np.arange(0.0, seconds, 1.0 / RATE)
    velocity = sum(0.06 / k * np.sin(2 * np.pi * 0.41 * k**1.3 * time + k) for k in range(1, 8))
    velocity[(time % 11.0) > 9.8] = 0.0
    counted = (time > 1.5) & (np.abs(time - 15.0) > 0.8)
    friction = 0.8 * np.tanh(velocity / 0.002)
    load = Series("normal load", "N", 3.0 + np.sin(1.7 * time))
    force = np.where(counted, -(60.0 * velocity + friction), 0.0) + noise.normal(0.0, NOISE, len(time))
    b = -float(velocity[counted] @ force[counted]) / float(velocity[counted] @ velocity[counted])
    outputs = {"nominal": -55.0 * velocity, "refit": -b * velocity, "augmented": -(60.0 * velocity + friction)}
    outputs = {name: np.where(counted, output, 0.0) for name, output in outputs.items()}
    frequency, _ = welch(force, RATE, nperseg=4096)
    densities = {name: welch(force - output, RATE, nperseg=4096)[1] for name, output in outputs.items()}
    speed = Series("sliding velocity", "m/s", velocity)
    deflection = Series("deflection", "m", force / 500.0)
    position = Series("position", "m", np.cumsum(velocity) / RATE)
    kept = {name: output[counted] for name, output in outputs.items()}
    return Evidence(
        "strokes.mcap",
        "y",
        time,
        Series("force on the probe", "N", force),
        counted,
        HELDOUT,
        outputs,
        noise=NOISE,
        states={"sliding_velocity": speed, "deflection": deflection, "load": load, "position": position},
        restoring=Curve(
            replace(deflection, values=deflection.values[counted]),
            Series("restoring force", "N", force[counted]),
            {"refit": 500.0 * deflection.values[counted]},
        ),
        friction=Curve(
            replace(speed, values=velocity[counted]),
            Series("friction", "N", force[counted] + 60.0 * velocity[counted]),
            {name: kept[name] + 60.0 * velocity[counted] for name in ("refit", "augmented")},
        ),
        spectrum=Spectrum(frequency, densities, np.full(len(frequency), 2 * NOISE**2 / RATE)),
    )


def diagnosis_of(verdict: str) -> Diagnosis:
    """A plausible diagnosis with that verdict."""
    karnopp = {
        "Fs": EffectParameter(0.98, "N", (0.95, 1.01)),
        "Fd": EffectParameter(0.79, "N", (0.76, 0.83)),
        "v_d": EffectParameter(0.004, "m/s", (0.0031, 0.0052)),
    }
    stick = NamedEffect("static_friction", "dry_friction", "friction", "law", karnopp)
    stribeck = Alternative("stribeck_friction", 0.0182, verdict == "ambiguous", "the same above 5 mm/s")
    fit = Fit(("y",), HELDOUT, 0.0161, HeldoutNrmse(0.412, 0.123, 0.0172), spread=2.0, unit="N")
    base = Diagnosis(
        verdict="no_mismatch",
        summary="What was found, and <what> to do & when.",
        fit=fit,
        recordings=("strokes.mcap",),
        preflight=(
            Finding("clock", "note", "1000 Hz, no gap"),
            Finding("force_bias", "warn", "the force reads 0.03 N in free space", {"bias_n": 0.03}),
        ),
        budget=(
            BudgetPart("parameters", 0.31),
            BudgetPart("static_friction", 0.55, 0.49),
            BudgetPart("shared", 0.0),
            BudgetPart("nameless", 0.11),
            BudgetPart("noise", 0.03),
        ),
        seconds=12.7,
        model="augmented_model.yaml",
    )
    mismatch = Mismatch(
        (BlockShare("friction", 0.93), BlockShare("contact", 0.07)),
        ((3.1, 4.0), (9.5, 10.25)),
        (0.1, 3.6),
        (Dependence("sliding_velocity", 0.77, "|v| < 0.005 m/s"), Dependence("load", 0.12, "")),
    )
    k2 = {"k2": FittedParameter(500.0, 612.3, "N/m", (608.0, 616.5)), "b1": FittedParameter(60.0, 57.0, "N s/m", None)}
    tried = (
        Candidate(("static_friction",), 0.0172, 0.106, 0.0005, "accepted", "best on held-out data"),
        Candidate(("stribeck_friction",), 0.0182, 0.105, 0.0005, "ambiguous", "0.6 noise floors behind"),
        Candidate(("coulomb_friction", "contact_gap"), 0.031, 0.092, 0.001, "rejected", "the gap adds nothing"),
        Candidate(("hunt_crossley_damping",), 0.118, 0.005, 0.21, "at a bound", "lambda at 1e4 1/m"),
        Candidate(("time_delay",), None, None, None, "rejected", "no gain when scored"),
    )
    found = replace(base, mismatch=mismatch, parameters=k2, candidates=tried, tried=61)
    match verdict:
        case "no_mismatch":
            return replace(base, fit=replace(fit, heldout_nrmse=HeldoutNrmse(0.0163, 0.0162, None)))
        case "parameters":
            return replace(base, verdict="parameters", parameters=k2, candidates=tried[2:])
        case "missing_physics":
            return replace(found, verdict="missing_physics", effects=(stick,))
        case "partly_explained":
            return replace(found, verdict="partly_explained", effects=(replace(stick, certain="family"),))
        case "ambiguous":
            what = "Slow strokes below 5 mm/s, 20 s: operator file next.csv."
            return replace(found, verdict="ambiguous", effects=(stick,), alternatives=(stribeck,), next_recording=what)
        case "unexplained":
            return replace(found, verdict="unexplained", effects=(TABLE,), candidates=tried[2:])
        case _:
            why = Finding("no_contact", "refuse", "the probe is never below the surface")
            return Diagnosis("insufficient_data", "No contact.", preflight=(why,), next_recording="Press down.")
