"""Machines from the specs of data/smach_golden.jsonl, with leaves that follow a script and note what they did."""

import threading

import grip_bt.smach_compat as smach


class Recorder:
    """What the leaves of one machine share: the count of activations, the trace, when to preempt."""

    def __init__(self, preempt_at):
        self.preempt_at = preempt_at
        self.root = None
        self.trace = []
        self._activations = 0
        self._lock = threading.Lock()

    def next_activation(self):
        with self._lock:
            self._activations += 1
            return self._activations - 1


class ScriptedState(smach.State):
    def __init__(self, spec, path, recorder):
        super().__init__(spec["outcomes"], spec["in"], spec["out"])
        self.spec, self.path, self.recorder, self.runs = spec, path, recorder, 0

    def execute(self, ud):
        spec, recorder = self.spec, self.recorder
        activation = recorder.next_activation()
        outcome = spec["outcomes"][spec["script"][self.runs % len(spec["script"])]]
        self.runs += 1
        if activation == recorder.preempt_at:
            recorder.root.request_preempt()
        read = {key: ud[key] if key in ud else "-" for key in spec["in"]}
        preempted = self.preempt_requested()
        if preempted and spec["preempt"] != "ignore":
            self.service_preempt()
            if spec["preempt"] == "serve_outcome" and "preempted" in spec["outcomes"]:
                outcome = "preempted"
        total = sum(value for value in read.values() if isinstance(value, int))
        for key in spec["out"]:
            ud[key] = (total + 7 * self.runs + len(self.path)) % 101
        recorder.trace.append([self.path, outcome, sorted([k, v] for k, v in read.items()), preempted])
        return outcome


def build(spec, recorder, path=""):
    """Return the state or container of a spec."""
    return _BUILDERS[spec["kind"]](spec, recorder, path)


def _leaf(spec, recorder, path):
    return ScriptedState(spec, path, recorder)


def _state_machine(spec, recorder, path):
    machine = smach.StateMachine(spec["outcomes"], spec["in"], spec["out"])
    if spec["initial"] is not None:
        machine.set_initial_state([spec["initial"]])
    with machine:
        for label, child, transitions, remapping in spec["states"]:
            state = build(child, recorder, f"{path}/{label}")
            smach.StateMachine.add(label, state, dict(transitions), remapping)
    return machine


def _sequence(spec, recorder, path):
    sequence = smach.Sequence(spec["outcomes"], spec["connector"], spec["in"], spec["out"])
    with sequence:
        for label, child, transitions, remapping in spec["states"]:
            state = build(child, recorder, f"{path}/{label}")
            smach.Sequence.add(label, state, dict(transitions), remapping)
    return sequence


def _concurrence(spec, recorder, path):
    concurrence = smach.Concurrence(spec["outcomes"], spec["default"], spec["in"], spec["out"], outcome_map=spec["map"])
    with concurrence:
        for label, child, remapping in spec["children"]:
            smach.Concurrence.add(label, build(child, recorder, f"{path}/{label}"), remapping)
    return concurrence


def _iterator(spec, recorder, path):
    iterator = smach.Iterator(
        list(spec["outcomes"]), spec["in"], spec["out"], spec["items"], spec["label"], spec["exh"]
    )
    with iterator:
        child = build(spec["child"], recorder, f"{path}/{spec['state']}")
        smach.Iterator.set_contained_state(
            spec["state"],
            child,
            loop_outcomes=list(spec["loop"]),
            break_outcomes=list(spec["break"]),
            final_outcome_map=spec["final"],
        )
    return iterator


_BUILDERS = {
    "leaf": _leaf,
    "sm": _state_machine,
    "seq": _sequence,
    "conc": _concurrence,
    "iter": _iterator,
}
