"""Damping that grows with the depth.

The law of `hunt_crossley_damping` along the surface normal: no jump of the force at a touch, and more loss where it
is deep.

Easily confused with:

- `normal_viscoelastic_relaxation`: both lose energy in presses; a press that is held tells them apart: damping ends
  with the motion, relaxation goes on.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.hunt_crossley_damping import EFFECT as ALONG

EFFECT = along_normal(ALONG)
