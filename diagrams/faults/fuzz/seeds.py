"""Small valid files of every form that is read, which strange ones are made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from mmt_drake.cloud import Cloud
from mmt_drake.cloud.files import write_cloud
from mmt_drake.diagrams.stations.scenario import SCENARIOS, load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.hw.link.keys import write_key
from mmt_drake.model_files import load_model
from mmt_drake.recording import Recording, load, save
from mmt_drake.simulate import simulate

MODELS = {
    "flexible_box": "structure: flexible_box\nparameters: {m: 0.5, k1: 0.0, k2: 450.0, b1: 20.0, b2: 25.0, Fc: 0.05}\n"
    "normal: {k: 400.0, b: 8.0}\neffects:\n  - {name: static_friction, parameters: {Fs: 0.1, Fd: 0.05, v_d: 0.005}}\n",
    "kelvin_voigt": "structure: kelvin_voigt\nparameters: {k: 450.0, b: 22.0, x0: 0.01}\n",
    "driven_body": "structure: driven_body\nparameters: {m: 1.8, b: 11.0, k: 80.0, Fc: 0.5}\n"
    "gravity: {kind: pendulum, value: 0.5}\n",
}
RECORDED = {"flexible_box": "contact", "kelvin_voigt": "axis", "driven_body": "driven"}
"""Structure -> name of its recording."""


def write_seeds(folder: Path) -> None:
    """Write models, what they answer to a motion as `.csv`, `.npz` and `.mcap`, bags, clouds, scenarios, a key."""
    t = np.arange(0.0, 0.6, 0.005)
    moves = {
        "contact": {"position_x": 0.0 * t, "position_y": 0.02 * np.sin(9.0 * t), "position_z": 0.004 * np.cos(8.0 * t)},
        "axis": {"position": 0.02 * np.sin(9.0 * t)},
        "driven": {"input": 5.0 * np.sin(9.0 * t), "output": 0.0 * t},
    }
    for structure, name in RECORDED.items():
        (folder / f"{structure}.yaml").write_text(MODELS[structure])
        motion = Recording(t, moves[name] | ({"force": 0.0 * t} if name == "axis" else {}), name)
        save(motion, folder / f"{name}.csv")
        recording = simulate(load_model(folder / f"{structure}.yaml"), load(folder / f"{name}.csv", forces=False))
        for ending in (".csv", ".npz", ".mcap"):
            if ending != ".mcap" or name == "contact":
                save(recording, folder / f"{name}{ending}")
        if name == "driven":  # as one of the public data sets has it
            np.savez(folder / "public.npz", t_s=t, u_V=t, force_N=recording["input"], q_m=recording["output"])
    _write_bags(folder, t, np.column_stack(list(moves["contact"].values())))
    grid = np.linspace(-0.05, 0.05, 15)
    points = np.column_stack([np.repeat(grid, 15), np.tile(grid, 15), np.zeros(225)])
    for ending in (".ply", ".pcd", ".xyz"):
        write_cloud(Cloud(points), folder / f"cloud{ending}")
    for scenario in SCENARIOS.glob("*.yaml"):
        (folder / scenario.name).write_text(scenario.read_text())
        # What has to be compiled is, before the clock starts.
        build_station(load_scenario(scenario, trust_library=True)).simulate(0.002)
    write_key(folder / "link.key")


def _write_bags(folder: Path, t: np.ndarray, positions: np.ndarray) -> None:
    """One motion as a ROS 1 bag and as a ROS 2 database."""
    for store, open_ in (
        (get_typestore(Stores.ROS1_NOETIC), lambda: Writer1(folder / "motion.bag")),
        (get_typestore(Stores.ROS2_HUMBLE), lambda: Writer2(folder / "ros2", version=9)),
    ):
        vector = store.types["geometry_msgs/msg/Vector3"]
        ros1 = (folder / "motion.bag").exists() is False
        with open_() as bag:
            connection = bag.add_connection("/telerobot/pose", vector.__msgtype__, typestore=store)
            for time, position in zip(t, positions, strict=True):
                serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
                bag.write(connection, round(1e9 * (1.0 + time)), serialize(vector(*position), vector.__msgtype__))
    next((folder / "ros2").glob("*.db3")).rename(folder / "motion.db3")
