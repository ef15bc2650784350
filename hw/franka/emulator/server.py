"""The simulator of `franky-sim` with what it leaves out: contact force, errors, faults of the link.

It serves the protocol of the robot on one loopback address. Force comes in at our own seam: it pushes the simulated
arm and appears in the estimate that the robot reports, in the robot's sign.
"""

import socket
import time
from dataclasses import dataclass, fields
from typing import Any

import mujoco
import numpy as np
from franky_sim import SimulationServer, franka_robot_protocol
from franky_sim.franka_robot_protocol import (
    AutomaticErrorRecoveryStatus,
    BaseCommand,
    MoveStatus,
    RobotCommand,
    RobotMode,
)
from franky_sim.franka_robot_server import FrankaRobotServer
from franky_sim.franka_server import NonBlockingReceiver
from franky_sim.mujoco_simulator import MujocoSimulator
from numpy.typing import NDArray

_ERRORS = 41
_TIP_BODY = "robot0_hand"


@dataclass
class World:
    """What the arm meets and what is wrong with it; base frame.

    Attributes:
        push: force on the tip [N].
        wall_height, wall_stiffness: a floor that pushes the tip up [m], [N/m].
        bias: of the estimated force, in the sign of a force on the tip [N].
        reflex: number of the error with which the robot stops by itself; below zero: none.
        user_stopped: a person at the robot keeps it stopped.
        unrecoverable: its recovery is refused.
        silent: it sends nothing.
        nan: its velocities are not numbers.
        drop: of so many states one is sent (1: all).
    """

    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wall_height: float = -1.0
    wall_stiffness: float = 0.0
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reflex: int = -1
    user_stopped: bool = False
    unrecoverable: bool = False
    silent: bool = False
    nan: bool = False
    drop: int = 1


class RobotServer(FrankaRobotServer):
    """The robot's own protocol, with errors."""

    def __init__(self, world: World, *args: Any) -> None:
        self.world, self.force, self._sent = world, np.zeros(3), 0
        super().__init__(*args)

    @property
    def stopped(self) -> bool:
        """Whether it may not move."""
        return self.world.reflex >= 0 or self.world.user_stopped

    def start_motion(self, *args: Any) -> None:
        """Start one, unless it is stopped."""
        if self.stopped:
            raise ValueError("stopped")  # the simulator answers `aborted`
        super().start_motion(*args)

    def apply_errors(self) -> None:
        """Abort the motion that is running, as the robot does."""
        if self.stopped and self.current_motion_id:
            status = MoveStatus.kReflexAborted if self.world.reflex >= 0 else MoveStatus.kEmergencyAborted
            motion = self.current_motion_id
            self.stop_motion(send_preemption_signal=False)
            BaseCommand.send_response(self._tcp_socket, RobotCommand.kMove, motion, status)
            self.reset_current_motion_id()

    def send_state(self) -> None:
        """Send the state of this millisecond, unless the link is at fault."""
        self._sent += 1
        if not self.world.silent and self._sent % self.world.drop == 0:
            super().send_state()

    def _get_state_bytes(self) -> bytes:
        world = self.world
        reported = tuple(-(self.force + np.asarray(world.bias)))  # the robot's sign: what it does to the environment
        state = self.robot_state.replace(O_F_ext_hat_K=(*reported, 0.0, 0.0, 0.0))
        if world.nan:
            state = state.replace(dq=(float("nan"),) * 7)
        if world.user_stopped:
            state = state.replace(robot_mode=RobotMode.kUserStopped)
        elif world.reflex >= 0:
            errors = tuple(i == world.reflex for i in range(_ERRORS))
            state = state.replace(robot_mode=RobotMode.kReflex, errors=errors, reflex_reason=errors)
        packed: bytes = state.pack_state()
        return packed

    def _setup_udp_connection(self, network_udp_port: int) -> None:
        super()._setup_udp_connection(network_udp_port)
        # The simulator would listen on every interface of the machine.
        listening: socket.socket = vars(self)["_FrankaServer__udp_socket"]
        listening.close()
        loopback = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        loopback.bind((self.hostname, 0))
        loopback.setblocking(False)
        self._FrankaServer__udp_socket = loopback
        self._FrankaServer__udp_receiver = NonBlockingReceiver(loopback)


def _recover(command: Any, server: RobotServer) -> None:
    if server.world.user_stopped or server.world.unrecoverable:
        command.reply(AutomaticErrorRecoveryStatus.kCommandNotPossibleRejected)
        return
    server.world.reflex = -1
    command.reply(AutomaticErrorRecoveryStatus.kSuccess)


franka_robot_protocol.AutomaticErrorRecoveryCommand.handle = _recover


class Emulator(SimulationServer):
    """The simulation and its server."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._simulator = MujocoSimulator()
        self._simulator.__enter__()
        self._simulator.add_robot()
        super().__init__(self._simulator)
        self._simulator.register_pre_step_callback(self._push)
        self._previous, self._velocity = np.zeros(3), np.zeros(3)
        self.ticks = 0

    def init(self) -> None:
        """Bind to a loopback address and start."""
        for robot in self.sim.robots:
            server = RobotServer(self.world, robot, self._remaining_hostname_candidates)
            server.init()
            self.robot_servers.append(server)
        self.sim.start()
        self._previous = self.position()

    @property
    def server(self) -> RobotServer:
        """Of the one robot."""
        server: RobotServer = self.robot_servers[0]
        return server

    def position(self) -> NDArray[np.float64]:
        """(3) of the tip [m]."""
        robot = self.server.robot
        return np.array(robot.kinematics(np.array(robot.inner_state.q)).translation)

    def tick(self, until: float) -> None:
        """One millisecond, which ends at a wall time if the machine is quick enough."""
        self.server.apply_errors()
        self.run_once(realtime=False)
        position = self.position()
        self._velocity, self._previous = (position - self._previous) / 1e-3, position
        self.ticks += 1
        time.sleep(max(0.0, until - time.monotonic()))

    def reset(self) -> None:
        """Nothing wrong, and the arm at rest where it began."""
        for field in fields(World):
            setattr(self.world, field.name, field.default)
        robot, data = self.server.robot, self.sim.data
        data.qpos[robot._qpos_addrs] = robot.initial_q
        data.qvel[:] = 0.0
        self.server._reset_state()  # it holds this posture
        self._previous = self.position()

    def state(self) -> dict[str, Any]:
        """What the arm does."""
        state = self.server.robot_state
        return {
            "position": self._previous.tolist(),
            "velocity": self._velocity.tolist(),
            "torque": list(state.tau_J),
            "dq": list(state.dq),
            "mode": state.controller_mode.name,
            "moving": self.server.current_motion_id > 0,
            "force": self.server.force.tolist(),
            "load": [state.m_load, *state.F_x_Cload],
            "ticks": self.ticks,
        }

    def _push(self, simulator: Any) -> None:
        world, server = self.world, self.server
        force = np.array(world.push, dtype=float)
        force[2] += max(0.0, world.wall_stiffness * (world.wall_height - self._previous[2]))
        server.force = force
        model, data = simulator.model, simulator.data
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, _TIP_BODY)
        mujoco.mj_applyFT(model, data, force, np.zeros(3), self._previous, body, data.qfrc_applied)
