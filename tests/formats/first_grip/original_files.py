"""Files in the formats of the first GRIP, made here: settings with pickled graphs, and configuration."""

from __future__ import annotations

import pickle
import struct
from collections import OrderedDict
from pathlib import Path
from typing import Any


def variant(data: bytes) -> str:
    """Return bytes of a pickle as Qt writes a Python object into a file of settings."""
    name = b"PyQt_PyObject\0"
    raw = struct.pack(">II", 127, len(name)) + name + struct.pack(">I", len(data)) + data
    return f'"@Variant({escaped(raw)})"'


def escaped(raw: bytes) -> str:
    """Return bytes with Qt's escapes; a digit after an escape is escaped too, as Qt does."""
    text, digits = "", False
    for byte in raw:
        character = chr(byte)
        if byte == 0:
            text, digits = text + "\\0", True
            continue
        if character in '"\\':
            text += "\\" + character
        elif 32 <= byte < 127 and not (digits and character in "0123456789abcdefABCDEF"):
            text += character
        else:
            text, digits = text + f"\\x{byte:x}", True
            continue
        digits = False
    return text


class Graph:
    """A container as the editor saved it."""

    def __init__(self, outcomes: list[str]):
        self.ids = iter(range(100, 100_000_000))
        self.ends = {name: next(self.ids) for name in ("Start", *outcomes)}
        self.inputs: dict[str, int] = {}
        self.outputs: dict[tuple[str, str], int] = {}
        self.states: list[Any] = []
        self.machines: list[Any] = []
        self.connectors: list[Any] = []

    def add(
        self, name: str, kind: str, outcomes: list[str], content: dict[str, Any] | None, named: bool = True
    ) -> None:
        self.inputs[name] = next(self.ids)
        sockets = []
        for outcome in outcomes:
            self.outputs[name, outcome] = next(self.ids)
            socket = self.outputs[name, outcome]
            sockets.append(OrderedDict(id=socket, name=outcome) if named else socket)
        entry = OrderedDict(
            name=name, type=kind, pos=(1.5, 2.0), input_socket=self.inputs[name], output_sockets=sockets
        )
        if content is None:
            self.machines.append(entry)
        else:
            self.states.append(OrderedDict(entry, content=OrderedDict(content)))

    def connect(self, start: int, end: int) -> None:
        self.connectors.append(OrderedDict(start=start, end=end))

    def lead(self, state: str, outcome: str, target: str) -> None:
        end = self.ends.get(target) or self.inputs[target]
        self.connect(self.outputs[state, outcome], end)

    def begin(self, *names: str) -> None:
        for name in names:
            self.connect(self.ends["Start"], self.inputs[name])

    def data(self) -> OrderedDict[str, Any]:
        terminals = [OrderedDict(id=number, name=name, position=(0.0, 1.0)) for name, number in self.ends.items()]
        return OrderedDict(
            terminal_sockets=terminals, states=self.states, state_machines=self.machines, connectors=self.connectors
        )


def write_settings(file: Path, graphs: dict[str, Graph], protocol: int = 2) -> None:
    """Write a task file; keys are the containers' paths, with Qt's separator."""
    lines = ["[General]", "version=1", ""]
    for path, graph in graphs.items():
        group, _, rest = path.partition("\\")
        lines += [
            f"[{group}]",
            f"{rest}{chr(92) if rest else ''}container={variant(pickle.dumps(graph.data(), protocol))}",
        ]
        lines.append("view\\zoom=-3")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def pick_and_place() -> dict[str, Graph]:
    """Return a task with a nested machine, a concurrent one, planning, a sensor, a component and a counter."""
    root = Graph(["Task success", "Task failure"])
    two = ["success", "failure"]
    root.add(
        "try counter", "Counter", ["success", "finished"], {"initial_value": "0", "end_value": "3", "output": "tries"}
    )
    root.add("look", "Kinect2", two, {"sensor_topic": "pointcloud", "output": "pc2"})
    root.add("grasping", "BasicGrasping", ["0", "1", "state_failure"], {"input": "pc2", "output": "grasp_pose"})
    root.add("reach", "StateMachine", two, None)
    root.add("both", "ConcurrentStateMachine", ["done", "not_done"], None)
    root.begin("try counter")
    for state, outcome, target in (
        ("try counter", "success", "look"),
        ("try counter", "finished", "Task failure"),
        ("look", "success", "grasping"),
        ("look", "failure", "try counter"),
        ("grasping", "0", "reach"),
        ("grasping", "1", "try counter"),
        ("grasping", "state_failure", "Task failure"),
        ("reach", "success", "both"),
        ("reach", "failure", "try counter"),
        ("both", "done", "Task success"),
        ("both", "not_done", "Task failure"),
    ):
        root.lead(state, outcome, target)
    reach = Graph(two)
    plan = {"group_name": "panda_arm", "target_type": "", "target_name": "grasp_pose", "plan_name": ""}
    reach.add("plan", "ComputePlan", two, plan)
    reach.add("move", "Move", two, {"group_name": "panda_arm", "plan_name": ""}, named=False)
    reach.begin("plan")
    for state, outcome, target in (
        ("plan", "success", "move"),
        ("plan", "failure", "failure"),
        ("move", "success", "success"),
        ("move", "failure", "failure"),
    ):
        reach.lead(state, outcome, target)
    both = Graph(["done", "not_done"])
    home = {"group_name": "panda_arm", "target_type": "joint state", "target_name": "above_bin", "plan_name": "home"}
    both.add("plan home", "ComputePlan", two, home)
    both.add("reset", "ReinitialiseManagers", two, {})
    both.begin("plan home", "reset")
    for name in ("plan home", "reset"):
        both.lead(name, "success", "done")
        both.lead(name, "failure", "not_done")
    return {"root": root, "root\\reach": reach, "root\\both": both}


CONFIGURATION = {
    "joint_states.yaml": "above_bin: {panda_joint1: 1.49, panda_joint2: 0.48}\nopen_gripper:\n    knuckle: 0\n",
    "poses.yaml": "camera_pose:\n  reference_frame: world\n  position: {x: 1.0, y: 0, z: 1.2}\n"
    "  orientation: {r: 0, p: 1.5707963267948966, y: 0}\n",
    "trajectories.yaml": "there:\n- {name: above_bin, interpolate_time: 0.1, pause_time: 0.2}\n",
    "sensors.yaml": "Kinect2:\n  launch_file: /home/user/ws/kinect2.launch\n  data_topics:\n"
    "    pointcloud: /kinect2/sd/points\n  frame_id: kinect2_ir\n  initial_pose: camera_pose\n",
    "methods.yaml": "BasicGrasping:\n  file: /home/user/ws/src/basic_grasping/scripts/server.py\n"
    "  action/service: /home/user/ws/src/basic_grasping/srv/Grasp.srv\n  server_name: grasping\n"
    "  node_type: server.py\n  number_outcomes: 2\n  run_node: false\n",
    "planners.yaml": "panda_arm:\n  planner_name: BiTRRTkConfigDefault\n  robot_speed_factor: 0.5\n"
    "  number_plan_attempt: 2\n  planning_max_time: 1\n",
    "controllers.yaml": "arm_controller:\n  type: position_controllers/JointTrajectoryController\n  joints: [a]\n",
}


def write_configuration(folder: Path) -> Path:
    """Write a robot's configuration, with paths of another computer, and return its `.ini`."""
    (folder / "files").mkdir(parents=True)
    lines = ["[Robot%20integration%20area]", "Simulation%20parameters\\is_checked=true"]
    for name, text in CONFIGURATION.items():
        (folder / "files" / name).write_text(text)
        lines.append(f"Arm%20widget\\{name.partition('.')[0]}\\file_path=/home/user/grip/config/{name}")
    lines.append("Robot%20interface\\UE%20Robot%27s%20URDF%20file\\value=/home/user/panda.urdf.xacro")
    lines.append(f"Moveit\\package={variant(pickle.dumps(('panda_moveit', '/home/user/panda_moveit'), 2))}")
    file = folder / "robot.ini"
    file.write_text("\n".join(lines) + "\n")
    return file
