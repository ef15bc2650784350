"""How a surface stands in the one vector that kernels read: what all have in common."""

from mmt_drake.numeric.layout import Layout

PLANE, SPHERE, CYLINDER, SADDLE, STEP, HEIGHTS, MESH = map(float, range(7))

_next = Layout()
KIND = _next()  # one of the above
WORLD = _next()  # 1 where the surface is fixed to the world, 0 where it goes with the body
MU = _next()  # friction of the tip; infinite: it never slips
AT = _next(3)  # where its origin is [m]
TURN = _next(2)  # cosine and sine of how far it is turned about z
OWN = _next()  # from here on what a kind has of its own, see there
