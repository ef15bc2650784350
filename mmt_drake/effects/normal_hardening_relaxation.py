"""A contact whose normal force relaxes, more of it the deeper it is pressed.

The law of `hardening_relaxation` along the surface normal: tissue under a probe.

Easily confused with:

- `normal_viscoelastic_relaxation`: alike in presses of one depth; presses and holds of several depths tell them
  apart.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.hardening_relaxation import EFFECT as ALONG

EFFECT = along_normal(ALONG)
