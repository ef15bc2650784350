"""A contact that hardens or softens with its depth.

The law of `nonlinear_stiffness` along the surface normal, k3 z^3 beside normal.k: rubber or tissue that is pressed.

Easily confused with:

- `power_law_stiffness`: presses of one depth suit both; a light and a deep press tell them apart: near the surface
  one is as soft as its spring, the other bends most.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.nonlinear_stiffness import EFFECT as ALONG

EFFECT = along_normal(ALONG)
