"""Plants of arms whose recordings come without a file: lengths as makers publish them, masses guessed.

KR300: reach and heights of the data sheet of KUKA KR 300 R2500. PSM: an arm about a remote centre that slides along its
tool (Kazanzides et al. 2014, IEEE Int. Conf. Robotics and Automation); its counterweights and parallelogram are left
out. Schunk: lengths of the data sheet of the LWA 4P. Kinova: its last joint alone, upright.
"""

from __future__ import annotations

from typing import Any

from mmt_drake.arms.chain import ChainJoint, chain


def kr300() -> Any:
    """Six joints of the 300 kg class."""
    return chain(
        [
            ChainJoint((0.0, 0.0, 0.675), axis=(0.0, 0.0, -1.0), mass=300.0, size=0.6),
            ChainJoint((0.35, 0.0, 0.0), axis=(0.0, 1.0, 0.0), mass=250.0, size=1.2),
            ChainJoint((1.15, 0.0, 0.0), axis=(0.0, 1.0, 0.0), mass=200.0, size=0.8),
            ChainJoint((1.0, 0.0, -0.041), axis=(-1.0, 0.0, 0.0), mass=60.0, size=0.4),
            ChainJoint(axis=(0.0, 1.0, 0.0), mass=40.0, size=0.2),
            ChainJoint((0.24, 0.0, 0.0), axis=(-1.0, 0.0, 0.0), mass=50.0, size=0.2),
        ]
    )


def psm() -> Any:
    """Seven joints of a surgical arm, the third slides."""
    return chain(
        [
            ChainJoint(axis=(0.0, 1.0, 0.0), mass=5.0, size=0.3),
            ChainJoint(axis=(1.0, 0.0, 0.0), mass=2.0, size=0.3),
            ChainJoint(axis=(0.0, 0.0, -1.0), slides=True, mass=0.4, size=0.2),
            ChainJoint(axis=(0.0, 0.0, -1.0), mass=0.1, size=0.02),
            ChainJoint(axis=(1.0, 0.0, 0.0), mass=0.02, size=0.01),
            ChainJoint((0.0, 0.0, -0.0091), axis=(0.0, 1.0, 0.0), mass=0.02, size=0.01),
            ChainJoint(axis=(0.0, 1.0, 0.0), mass=0.02, size=0.01),
        ]
    )


def schunk() -> Any:
    """Six joints of a light arm."""
    return chain(
        [
            ChainJoint((0.0, 0.0, 0.205), mass=3.9, size=0.1),
            ChainJoint(axis=(0.0, 1.0, 0.0), mass=4.0, size=0.35),
            ChainJoint((0.0, 0.0, 0.35), axis=(0.0, -1.0, 0.0), mass=3.0, size=0.2),
            ChainJoint(mass=2.0, size=0.3),
            ChainJoint((0.0, 0.0, 0.305), axis=(0.0, 1.0, 0.0), mass=1.5, size=0.1),
            ChainJoint((0.0, 0.0, 0.075), mass=0.5, size=0.05),
        ]
    )


def last_joint() -> Any:
    """One joint that turns about the vertical."""
    return chain([ChainJoint(mass=0.5, size=0.05)])
