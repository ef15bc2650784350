"""One motion as the messages of a bag."""

from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from mmt_drake.recording import Recording

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
TOPICS = {"position": "/telerobot/pose", "velocity": "/telerobot/twist", "force": "/telerobot/wrench"}
PLAIN, GEOMETRY = "std_msgs/msg/", "geometry_msgs/msg/"
Messages = list[tuple[str, str, int, Any]]  # topic, type, log time [ns], message


def header(store: Any, stamp: int, frame: str = "table") -> Any:
    time = store.types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    extra = {"seq": 7} if store is ROS1 else {}
    return store.types["std_msgs/msg/Header"](stamp=time, frame_id=frame, **extra)


def make(store: Any, kind: str, numbers: Any, stamp: int = 0, frame: str = "table") -> tuple[str, Any]:
    """A message of a kind with these numbers; its type and itself."""
    types = store.types
    vector, point = types[f"{GEOMETRY}Vector3"], types[f"{GEOMETRY}Point"]
    if kind == "array":
        layout = types[f"{PLAIN}MultiArrayLayout"](dim=[], data_offset=0)
        return f"{PLAIN}Float64MultiArray", types[f"{PLAIN}Float64MultiArray"](layout, np.array(numbers, dtype=float))
    if kind == "labelled_array":
        dim = [types[f"{PLAIN}MultiArrayDimension"](label="theta", size=len(numbers), stride=1)]
        layout = types[f"{PLAIN}MultiArrayLayout"](dim=dim, data_offset=0)
        return f"{PLAIN}Float64MultiArray", types[f"{PLAIN}Float64MultiArray"](layout, np.array(numbers, dtype=float))
    if kind == "bool":
        return f"{PLAIN}Bool", types[f"{PLAIN}Bool"](bool(numbers))
    if kind == "string":
        return f"{PLAIN}String", types[f"{PLAIN}String"]("hello")
    if kind == "vector3":
        return f"{GEOMETRY}Vector3", vector(*numbers)
    zero = vector(0.0, 0.0, 0.0)
    content = {
        "pose": lambda: types[f"{GEOMETRY}Pose"](point(*numbers), types[f"{GEOMETRY}Quaternion"](0.0, 0.0, 0.0, 1.0)),
        "twist": lambda: types[f"{GEOMETRY}Twist"](vector(*numbers), zero),
        "wrench": lambda: types[f"{GEOMETRY}Wrench"](vector(*numbers), zero),
        "vector": lambda: vector(*numbers),
    }[kind]()
    name = f"{GEOMETRY}{ {'pose': 'Pose', 'twist': 'Twist', 'wrench': 'Wrench', 'vector': 'Vector3'}[kind] }Stamped"
    return name, types[name](header(store, stamp, frame), content)


def motion(count: int = 60, step: float = 0.01) -> Recording:
    time = np.arange(count) * step
    columns = {}
    for i, axis in enumerate("xyz"):
        columns[f"position_{axis}"] = 0.05 * np.sin(3.0 * time + i)
        columns[f"velocity_{axis}"] = 0.15 * np.cos(3.0 * time + i)
        columns[f"force_{axis}"] = np.cos(time + i)
    columns["in_contact"] = (columns["position_z"] < 0).astype(float)
    return Recording(time, columns)


def messages(store: Any, start: int = 0, kinds: dict[str, str] | None = None, frame: str = "table") -> Messages:
    """The motion as messages, log times 2 ms after the stamps."""
    kinds = kinds or {"position": "pose", "velocity": "twist", "force": "wrench"}
    recording, found = motion(), []
    for row, time in enumerate(recording.time):
        stamp = start + round(time * 1e9)
        for name, kind in kinds.items():
            numbers = recording.vector(name)[row].tolist()
            found.append((TOPICS[name], *make(store, kind, numbers, stamp, frame), stamp + 2_000_000))
        found.append(("/environment/in_contact", *make(store, "bool", recording["in_contact"][row]), stamp))
    return sorted(((topic, kind, log, message) for topic, kind, message, log in found), key=lambda entry: entry[2])
