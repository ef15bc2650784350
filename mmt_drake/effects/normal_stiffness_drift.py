"""A contact whose normal stiffness grows or falls with time.

The law of `stiffness_drift` along the surface normal: a surface that is compacted, warms up or dries.

Easily confused with:

- `normal_nonlinear_stiffness`: where presses grow deeper with time both stiffen; equal presses early and late tell
  them apart.
"""

from mmt_drake.effects.along_normal import along_normal
from mmt_drake.effects.stiffness_drift import EFFECT as ALONG

EFFECT = along_normal(ALONG)
