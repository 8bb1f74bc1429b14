"""A stranger's folder: whatever in it can be run writes a file that tells."""

from __future__ import annotations

from pathlib import Path

MARK = "mark-"
"""What the names of those files begin with."""
STRANGER = """from py_trees.behaviour import Behaviour
open('MARK', 'w')

class Listed(Behaviour):
    pass

def made(name, word):
    return Listed(name)
"""
TASKS = {
    "unlisted": 'root: {kind: foreign, behaviour: "os:system", args: {command: "touch MARKunlisted"}}',
    "popen": 'root: {kind: foreign, behaviour: "subprocess:Popen", args: {args: [touch, MARKpopen]}}',
    "display": 'root: {kind: foreign, behaviour: "py_trees.display:os.system", args: {command: "touch MARKdisplay"}}',
    "listed": """root:
  kind: sequence
  memory: false
  children:
    a: {kind: foreign, behaviour: "strangers:Listed"}
    b: {kind: foreign, behaviour: "strangers:made", args: {word: x}}
    c: {kind: retry, times: 2, child: {d: {kind: foreign, behaviour: "strangers.deep:Listed"}}}""",
    "nodes": """root:
  kind: sequence
  children:
    function: {node: own/function}
    manifest: {node: own/manifest, precondition: "1 < 2"}
    component: {node: component/evil}
    machine: {kind: subtask, task: tasks/listed.yaml}""",
    "robot": "root: {kind: fallback, children: {go: {node: arm/move_to, with: {state: home}}, s: {node: sensor/eye}}}",
}
FILES = {
    "grip.yaml": """grip: 1
robot: {xacro: robot.xacro, srdf: robot.srdf.xacro}
arms: {arm: {}}
code: [strangers, "strangers:made"]
sensors: {eye: {topics: {points: {topic: /points, type: sensor_msgs/msg/PointCloud2}}}}
processes:
  evil: {command: [touch, MARKprocess]}
  file: {launch: evil.launch.py}
""",
    "strangers/__init__.py": STRANGER.replace("MARK", "MARKforeign"),
    "strangers/deep.py": STRANGER.replace("MARK", "MARKdeep"),
    "nodes/own.py": """import grip_bt
open('MARKnode', 'w')

@grip_bt.leaf("own/function", codes=["x"])
def function() -> None:
    '''Do it.'''
""",
    "nodes/kept/leaf.py": "open('MARKleaf', 'w')\n",
    "nodes/kept/manifest.yaml": "id: own/manifest\ndoc: Do it.\nimplementation: leaf.py:Leaf\n",
    "components/evil/component.yaml": """name: evil
interface: std_srvs/srv/Trigger
server: /evil
outcomes: {done: "success", failed: "not success"}
start: {command: [touch, MARKcomponent]}
""",
    "components/evil/node/manifest.yaml": "id: component/evil\ndoc: Do it.\nimplementation: leaf.py:Evil\n",
    "components/evil/node/leaf.py": "open('MARKcomponent_leaf', 'w')\n",
    "robot.xacro": """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">
  <xacro:property name="a" value="${(lambda: [c for c in ().__class__.__base__.__subclasses__()
    if c.__name__ == '_wrap_close'][0].__init__.__globals__['system']('touch MARKxacro'))()}"/>
  <link name="base${a}"/></robot>
""",
    "robot.srdf.xacro": "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>${[].append(1)}</robot>\n",
    "eval.xacro": """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">
  <link name="$(eval open${'\\x28'}'MARKeval', 'w'${'\\x29'})"/></robot>
""",
    "evil.launch.py": "open('MARKlaunch', 'w')\n\ndef generate_launch_description():\n    return None\n",
    "evil.launch.xml": """<launch>
  <arg name="a" default="$(command 'touch MARKcommand')"/>
  <executable cmd="touch MARKexecutable"/></launch>
""",
    "plain.launch.xml": '<launch><executable cmd="touch MARKplain"/></launch>',
    "legacy.py": """import smach
open('MARKsmach', 'w')


class A(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["done"])
        open('MARKstate', 'w')


def main():
    sm = smach.StateMachine(outcomes=["done"])
    with sm:
        smach.StateMachine.add("A", A(), transitions={"done": "done"})
    sm.execute()
""",
    "tree.xml": "<root BTCPP_format='4'><BehaviorTree ID='t'><Script code=\"x:=1\"/></BehaviorTree></root>\n",
    "campaign.yaml": "campaign: 1\ntask: tasks/nodes.yaml\nrobot: fake\nseeds: [0]\nvariants: {one: {}}\n",
    "conftest.py": "open('MARKconftest', 'w')\n",
    "sitecustomize.py": "open('MARKsite', 'w')\n",
}


def make(folder: Path) -> None:
    """Write it.

    Args:
        folder: where; files that tell are written beside it.
    """
    mark = str(folder.parent / MARK)
    tasks = {f"tasks/{name}.yaml": f"grip: 1\nname: {name}\n{text}\n" for name, text in TASKS.items()}
    for name, text in {**FILES, **tasks}.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text.replace("MARK", mark))


def marks(folder: Path) -> list[str]:
    """Return what was run, by the names of the files that tell."""
    return sorted(file.name.removeprefix(MARK) for file in folder.parent.glob(f"{MARK}*"))
