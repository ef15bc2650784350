"""A contact whose normal force depends on the way that led to its depth, however slowly.

The law of `hysteresis` (Bouc and Wen) along the surface normal: pressing takes more force than letting go.

Easily confused with:

- `normal_hunt_crossley_damping`: both make a loop over the depth; slow presses tell them apart: damping then closes
  its loop.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.hysteresis import EFFECT as ALONG

EFFECT = along_normal(ALONG)
