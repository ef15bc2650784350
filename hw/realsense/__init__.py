"""Depth cameras: from depth images to clouds of the surface in the table frame, measured, recorded or simulated.

Every source ends in the same `DepthToCloud`: a RealSense camera or a recording of one (`stream`, `worker`, `camera`),
and Drake's renderer with a camera's errors put on it (`noise`, `simulated`).
"""
