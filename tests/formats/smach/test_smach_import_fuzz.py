"""Random programs that build machines: what is called exact is what they build, whatever world they run in."""

import os
import random
import sys
from types import ModuleType

import pytest
from smach_runs import record

from grip_bt import smach_compat

PROGRAMS = int(os.environ.get("GRIP_FUZZ_TASKS", "24"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
HEAD = """import datetime, json, os, random, sys, time
import rospy
import smach

HERE = os.path.dirname(os.path.abspath(__file__))
REGISTRY = {}
COUNT = 0

class Go(smach.State):
    EXTRA = []
    def __init__(self, name, **more):
        smach.State.__init__(self, outcomes=['there'] + self.EXTRA)
        self.name = name

class Settings(object):
    pass

def register(name):
    REGISTRY[name] = len(REGISTRY)
    return name

SETTINGS = Settings()
"""
# What may change the list `names`, the class of the states, or nothing; some of it hangs on the world, some doesn't.
WORLDLY = [
    "names += os.environ.get('GRIP_FUZZ', 'P,Q').split(',')",
    "names += ['E' + x for x in os.getenv('GRIP_FUZZ', 'P').split(',')]",
    "if os.environ.get('GRIP_FUZZ'):\n        names.append('ENV')",
    "if 'GRIP_FUZZ' in os.environ:\n        Go.EXTRA = ['more']",
    "for room in rospy.get_param('~rooms', ['R1']):\n        names.append(room.upper())",
    "if rospy.get_param('~flag', True):\n        names.append('FLAG')",
    "if rospy.get_param('~speed', 0.5) > 1.0:\n        names.append('FAST')",
    "if rospy.get_param('~tool', None) is None:\n        names.append('NO_TOOL')",
    "names.append('L%d' % len(rospy.get_param('~rooms', ['R1'])))",
    "names.append('T' + rospy.get_param('~tool', 'none'))",
    "names.append(f'F{rospy.get_param(\"~speed\", 1.0)}')",
    "names.append('J{}'.format(rospy.get_param('~count', 2)))",
    "names.append('_'.join(['K'] + [rospy.get_param('~tool', 'none')]))",
    "names = names * int(rospy.get_param('~count', 1)) if False else names[:rospy.get_param('~count', 2)]",
    "random.shuffle(names)",
    "names.append(random.choice(['X', 'Y', 'Z']))",
    "names += [x or 'UNSET' for x in map(os.getenv, ['GRIP_FUZZ'])]",
    "names.sort(key=lambda name: random.random())",
    "names.append('N%d' % random.randint(0, 5))",
    "if random.random() > 0.5:\n        names.append('CHANCE')",
    "names += list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})",
    "for each in {'S1', 'S2', 'S3', 'S4', 'S5', 'S6'}:\n        names.append(each)",
    "names += [x for x in set('uvwxyz')]",
    "names.append(list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})[0])",
    "some = tuple({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})\n    names.append('%s_%s' % some[:2])",
    "some = list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})\n    some.pop(); names += sorted(some)",
    "some = list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})\n    del some[2]\n    Go.EXTRA = some",
    "some = list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})\n    if some.index('S1') < 3:\n        names.append('EARLY')",
    "if len(sys.argv) > 1:\n        names.append(sys.argv[1])",
    "if sys.argv[1:]:\n        names.append(sys.argv[1])",
    "try:\n        names.append(rospy.get_param('~made', {})['k'])\n    except KeyError:\n        names.append('NO_K')",
    "if rospy.get_param('~rooms', []):\n        names.append(rospy.get_param('~rooms', [])[0])",
    "if 'verbose' in sys.argv:\n        names.append('VERBOSE')",
    "names.append('C%d' % (int(time.time() * 1000) % 1000))",
    "if datetime.datetime.now().microsecond % 2:\n        names.append('ODD')",
    "if os.path.exists('/tmp/grip_fuzz_flag_%d' % os.getpid()):\n        names.append('FILE')",
    "names.append('P%d' % os.getpid())",
    "n = 0\n    while n < rospy.get_param('~count', 2):\n        n += 1\n        names.append('W%d' % n)",
    "setattr(Go, 'EXTRA', ['x'] if rospy.get_param('~flag', True) else ['y'])",
    "setattr(SETTINGS, 'kind', rospy.get_param('~tool', 'none'))\n    names.append(SETTINGS.kind)",
    "if hasattr(rospy, 'special'):\n        names.append('SPECIAL')",
    "name = 'M'\n    if rospy.get_param('~flag', True):\n        name += 'ORE'\n    names.append(name)",
    "name = 'M'\n    if rospy.get_param('~tool', 'none') == 'hand':\n        name += 'H'\n"
    "    if name == 'MH':\n        names.append('MH')",
    "if not rospy.get_param('~flag', True):\n        print(names.append('PRINTED'))",
    "names.append(MISSING)",
    "names += [str(x) for x in range(rospy.get_param('~count', 2))]",
    "names.insert(0 if rospy.get_param('~flag', True) else 1, 'I')",
    "names.append({True: 'YES', False: 'NO'}[bool(rospy.get_param('~flag', True))])",
    "names.append({'none': 'NONE', 'hand': 'HAND'}.get(rospy.get_param('~tool', 'none'), 'OTHER'))",
    "names.append(max('A', rospy.get_param('~tool', 'none')))",
    "try:\n        names.append(['A0', 'A1'][rospy.get_param('~count', 0)])\n"
    "    except IndexError:\n        names.append('LATE')",
    "global COUNT\n    COUNT += rospy.get_param('~count', 2)\n    if COUNT > 3:\n        names.append('MANY')",
    "register('r%s' % rospy.get_param('~count', 2)); names += sorted(REGISTRY)",
    "with open(os.environ.get('GRIP_FUZZ_FILE', os.path.join(HERE, 'lines.txt'))) as file:\n"
    "        names += [line.strip() for line in file]",
]
STEADY = [
    "names += ['B', 'C']",
    "for i in range(3):\n        names.append('I%d' % i)",
    "with open(os.path.join(HERE, 'config.json')) as file:\n        names += json.load(file)['rooms']",
    "with open(os.path.join(HERE, 'lines.txt')) as file:\n        names += [line.strip() for line in file]",
    "register('one'); register('two'); names += sorted(REGISTRY)",
    "names.reverse()",
    "names.pop() if len(names) > 2 else None",
    "setattr(Go, 'EXTRA', ['kept'])",
    "rospy.loginfo('building %s with %d states' % (rospy.get_param('~tool', 'none'), len(names)))",
    "if rospy.get_param('~verbose', False):\n        rospy.loginfo('names: {}'.format(names))",
    "if rospy.get_param('~speed', 0.5) > 1.0:\n        print('fast: {}'.format(names))",
    "day = 'D'\n    if datetime.date.today().day < 10:\n        day += '0'\n    SETTINGS.day = day",
    "SETTINGS.speed = rospy.get_param('~speed', 0.5) * 2",
    "names = sorted(set(names))",
    "SETTINGS.kinds = list({'S1', 'S2', 'S3', 'S4', 'S5', 'S6'})",
    "n = 0\n    while n < 2:\n        n += 1\n        names.append('V%d' % n)",
    "names = [n for n in names if n != 'C']",
    "for key, value in sorted({'k': 1, 'l': 2}.items()):\n        names.append('%s%d' % (key, value))",
    "pose = rospy.Pose(*rospy.transform(rospy.get_param('~count', 2)))",
]
TOP = [
    "try:\n    import grip_fuzz_missing\n    MISSING = 'M1'\nexcept ImportError:\n    MISSING = 'M2'",
    "if rospy.get_param('~flag', True):\n    Go.EXTRA = ['top']",
    "import random as chance\nMISSING = 'M%d' % chance.randint(0, 9)",
    "MISSING = os.environ.get('GRIP_FUZZ', 'M0')",
    "MISSING = 'M'",
]
TAIL = """
    names = list(dict.fromkeys(names))
    sm = smach.StateMachine(['over', 'more', 'kept', 'x', 'y', 'top'])
    with sm:
        for name, after in zip(names, names[1:] + ['over']):
            smach.StateMachine.add(name, Go(name, speed=SETTINGS), {'there': after})
"""
AFTER = [
    "",
    "    for room in rospy.get_param('~more', []):\n        with sm:\n"
    "            smach.StateMachine.add(room, Go(room), {'there': 'over'})\n",
    "    if rospy.get_param('~viewer', False):\n        rospy.viewer(sm)\n",
    "    if os.environ.get('GRIP_FUZZ'):\n        sm.set_initial_state(names[-1:])\n",
]
WORLDS = [
    {},
    {"env": "P2,Q2", "params": {"rooms": ["r2", "r3"], "flag": False, "speed": 2.0, "tool": "hand", "count": 1}},
    {
        "env": "x",
        "params": {"made": {"k": "K1"}, "count": 3, "more": ["M1", "M2"], "verbose": True, "tool": "none"},
        "argv": ["p", "verbose"],
    },
    {"missing": True, "params": {"viewer": True, "rooms": [], "count": 0}, "argv": ["p", "other"]},
]


def program(seed):
    """Return a program, and whether it may hang on the world at all."""
    drawn = random.Random(seed)
    worldly = drawn.sample(WORLDLY, drawn.choice((0, 1, 1, 2)))
    body = worldly + drawn.sample(STEADY, drawn.randint(1, 4))
    drawn.shuffle(body)
    top, after = drawn.choice(TOP) if worldly else TOP[-1], drawn.choice(AFTER) if worldly else ""
    called = "names.append(MISSING)" in body
    steps = "".join(f"    {step}\n" for step in body)
    globals_ = "    global COUNT\n" if "global COUNT" in steps else ""
    steps = steps.replace("global COUNT\n    ", "")
    head = f"{HEAD}\n{top}\n\ndef build():\n{globals_}    names = ['A']\n"
    return head + steps + TAIL + after + "    return sm\n", not worldly and not called


def built(file, world, monkeypatch):
    """Return what the program builds in a world; None where it raises."""
    rospy = ModuleType("rospy")
    unset = object()

    def get_param(name, default=unset):
        if name[1:] in world.get("params", {}):
            return world["params"][name[1:]]
        if default is unset:
            raise KeyError(name)
        return default

    rospy.get_param = get_param
    rospy.loginfo = rospy.viewer = rospy.Pose = lambda *given: None
    rospy.transform = lambda *given: [1, 2]
    with monkeypatch.context() as patched:
        patched.setitem(sys.modules, "rospy", rospy)
        patched.setitem(sys.modules, "smach", smach_compat)
        if world.get("missing"):
            patched.setitem(sys.modules, "grip_fuzz_missing", ModuleType("grip_fuzz_missing"))
        patched.setattr(sys, "argv", world.get("argv", ["p"]))
        if "env" in world:
            patched.setenv("GRIP_FUZZ", world["env"])
        names = {"__name__": "fuzzed", "__file__": str(file)}
        try:
            exec(compile(file.read_text(), str(file), "exec"), names)
            return shape(names["build"]())
        except Exception:  # noqa: BLE001 - such a program builds nothing in this world
            return None


def shape(machine):
    """Return what a machine is."""
    edges = {label: dict(machine._transitions[label]) for label in machine.get_children()}
    ends = {label: state.get_registered_outcomes() for label, state in machine.get_children().items()}
    return list(machine.get_children()), edges, ends, machine.get_initial_states()


def found_shape(container):
    """Return what was found, in the same words."""
    edges = {label: {o: c.transitions.get(o) for o in c.state.outcomes} for label, c in container.added.items()}
    ends = {label: tuple(c.state.outcomes) for label, c in container.added.items()}
    return list(container.added), edges, ends, [container.initial]


@pytest.mark.parametrize("part", range(4))
def test_what_is_exact_is_what_the_program_builds_in_every_world(part, tmp_path, monkeypatch):
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    exact = steady = 0
    for seed in range(FIRST + part, FIRST + PROGRAMS, 4):
        folder = tmp_path / str(seed)
        folder.mkdir()
        (folder / "config.json").write_text('{"rooms": ["HALL", "YARD"]}')
        (folder / "lines.txt").write_text("ONE\nTWO\n")
        file = folder / "program.py"
        text, alike = program(seed)
        file.write_text(text)
        machines = [c for c in record(file).containers if c.verdict == "exact"]
        steady += alike
        exact += alike and len(machines) == 1
        if machines:
            wanted = found_shape(machines[0])
            for world in WORLDS:
                really = built(file, world, monkeypatch)
                assert really is None or really == wanted, (seed, world, text.split("def build")[1])
    assert exact == steady, "what hangs on nothing is exact"
