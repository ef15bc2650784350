"""A contact whose normal force relaxes while it is held down.

The law of `viscoelastic_relaxation` along the surface normal: a Maxwell branch beside normal.k, relaxed at each
touch.

Easily confused with:

- `normal_hysteresis`: alike at one frequency; the same press slow and fast tells them apart: only relaxation minds
  the time.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.viscoelastic_relaxation import EFFECT as ALONG

EFFECT = along_normal(ALONG)
