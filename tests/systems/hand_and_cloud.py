"""A hand and a surface, tick by tick, for systems that look for contact."""

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem


class HandAndCloud(LeafSystem):
    """Rows of an array, the last of which stays, on a port of any name, and a cloud as a function of the tick."""

    def __init__(self, name, rows, cloud):
        super().__init__()

        def tick(context):
            return round(context.get_time() * 1e3)

        self.DeclareVectorOutputPort(
            name, rows.shape[1], lambda c, out: out.SetFromVector(rows[min(tick(c), len(rows) - 1)])
        )
        self.DeclareAbstractOutputPort(
            "point_cloud", lambda: AbstractValue.Make(None), lambda c, out: out.set_value(cloud(tick(c)))
        )
