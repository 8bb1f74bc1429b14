"""Legacy source text of a machine of the golden file, or of one like those."""

LAST = "LAST"
"""The label of the state with which a branch of a Concurrence ends that is a state machine."""

HEAD = """import threading

import smach

TRACE = []
WORLD = {'activations': 0, 'preempt_at': (), 'request': None}
ENDED = {}
WAITING = {}
MADE = {}
TURN = threading.Condition()


class Scripted(smach.State):
    def __init__(self, path, outcomes, inputs, outputs, script, mode, after, own, later):
        smach.State.__init__(self, outcomes, inputs, outputs)
        self.path, self.labels, self.inputs, self.outputs, self.script = path, outcomes, inputs, outputs, script
        self.mode, self.after, self.own, self.later, self.runs = mode, after, own, later, 0
        MADE[path] = self

    def execute(self, ud):
        number = self.runs
        self.runs += 1
        with TURN:  # branches of a Concurrence take turns, in their order: `own` is the last state of this one
            WAITING[self.path] = self
            TURN.notify_all()
            assert TURN.wait_for(self.may_go, 120)
            del WAITING[self.path]
            activation = WORLD['activations']
            WORLD['activations'] += 1
        if activation in WORLD['preempt_at']:
            with TURN:  # its siblings have begun, so that the request finds them
                assert TURN.wait_for(self.others_wait, 120)
            WORLD['request'](self)
        outcome = self.work(ud, self.labels[self.script[number % len(self.script)]])
        with TURN:
            ENDED[self.path] = number + 1
            TURN.notify_all()
        return outcome

    def may_go(self):
        return self.after is None or ENDED.get(self.after, 0) > ENDED.get(self.own, 0)

    def others_wait(self):
        return all(any((path + '/').startswith(branch + '/') for path in WAITING) for branch in self.later)

    def work(self, ud, outcome):
        read = {key: ud[key] if key in ud else '-' for key in self.inputs}
        asked = self.preempt_requested()
        if asked and self.mode != 'ignore':
            self.service_preempt()
            if self.mode == 'serve_outcome' and 'preempted' in self.labels:
                outcome = 'preempted'
        total = sum(value for value in read.values() if isinstance(value, int))
        for key in self.outputs:
            ud[key] = (total + 7 * self.runs + len(self.path)) % 101
        TRACE.append([self.path, outcome, sorted([k, v] for k, v in read.items()), asked])
        return outcome


"""


def source_of(spec):
    """Return a file with a function `build` that builds the machine of a spec."""
    lines = []
    name = _emit(spec, "", lines)
    lines += [f"{name}.userdata.{key} = {value!r}" for key, value in spec["ud"].items()]
    lines.append(f"return {name}")
    return HEAD + "def build():\n" + "".join(f"    {line}\n" for line in lines)


def _emit(spec, path, lines, turn=None):
    """Append the lines that make a spec's object, and return an expression for it.

    Args:
        spec: of a state or container.
        path: its labels.
        lines: of the function that builds all.
        turn: in a branch of a Concurrence: the last state of the branch before or None, that of its own, and the
            branches that come later.
    """
    if spec["kind"] == "leaf":
        turns = turn or (None, path, [])
        given = (path, spec["outcomes"], spec["in"], spec["out"], spec["script"], spec["preempt"], *turns)
        return f"Scripted({', '.join(map(repr, given))})"
    name = "sm" + path.replace("/", "_")
    keys = f"input_keys={spec['in']}, output_keys={spec['out']}"
    outcomes = spec["outcomes"]
    if spec["kind"] == "sm":
        lines.append(f"{name} = smach.StateMachine({outcomes}, {keys})")
        if spec["initial"] is not None:
            lines.append(f"{name}.set_initial_state([{spec['initial']!r}])")
    elif spec["kind"] == "seq":
        lines.append(f"{name} = smach.Sequence({outcomes}, {spec['connector']!r}, {keys})")
    elif spec["kind"] == "conc":
        lines.append(f"{name} = smach.Concurrence({outcomes}, {spec['default']!r}, {keys}, outcome_map={spec['map']})")
    else:
        more = f"it={spec['items']}, it_label={spec['label']!r}, exhausted_outcome={spec['exh']!r}"
        lines.append(f"{name} = smach.Iterator({outcomes}, {keys}, {more})")
    lines.append(f"with {name}:")
    for call in _adds(spec, path, lines, turn):
        lines.append(f"    {call}")
    return name


def _adds(spec, path, lines, turn):
    calls, before = [], []
    if spec["kind"] == "iter":
        child = _emit(spec["child"], f"{path}/{spec['state']}", before, turn)
        given = f"loop_outcomes={spec['loop']}, break_outcomes={spec['break']}, final_outcome_map={spec['final']}"
        calls.append(f"smach.Iterator.set_contained_state({spec['state']!r}, {child}, {given})")
    elif spec["kind"] == "conc":
        lasts = [_last(child, f"{path}/{label}") for label, child, _ in spec["children"]]
        earlier = None
        for number, (label, child, remapping) in enumerate(spec["children"]):
            own = lasts[number]
            later = [f"{path}/{spec['children'][n][0]}" for n in range(number + 1, len(lasts)) if lasts[n]]
            made = _emit(child, f"{path}/{label}", before, (earlier, own, later) if own else None)
            earlier = own
            calls.append(f"smach.Concurrence.add({label!r}, {made}, remapping={remapping})")
    else:
        cls = {"sm": "StateMachine", "seq": "Sequence"}[spec["kind"]]
        for label, child, transitions, remapping, *more in spec["states"]:
            made = _emit(child, f"{path}/{label}", before, turn)
            constants = f", constants={more[0]}" if more and more[0] else ""
            calls.append(f"smach.{cls}.add({label!r}, {made}, {transitions}, {remapping}{constants})")
    lines[-1:-1] = before
    return calls


def _last(child, path):
    """Return the path of the state with which a branch ends; None where that isn't known."""
    if child["kind"] == "leaf":
        return path
    return f"{path}/{LAST}" if child["kind"] == "sm" and child["states"][-1][0] == LAST else None
