"""Legacy files, one per situation of the probes, that note in SEEN what their states see.

Each is (rows of smach_probes.md, what upstream ends with, source): an outcome, or ERROR where it raises.
"""

ERROR = None

HEAD = """import smach

SEEN = []
QUIRKS = {}


class Obj:
    def __init__(self):
        self.v = 1

    def m(self):
        return self.v


class Does(smach.State):
    def __init__(self, work, outcomes=['ok'], inputs=[], outputs=[]):
        smach.State.__init__(self, outcomes, inputs, outputs)
        self.work = work

    def execute(self, ud):
        return self.work(self, ud) or 'ok'


class Returns(Does):
    def execute(self, ud):
        return self.work(self, ud)


def note(*values):
    SEEN.append(values)


def caught(call):
    try:
        return call()
    except Exception as error:
        return type(error).__name__


def ok(state, ud):
    note('ran')


def flag(state, ud):
    note(state.preempt_requested())
    return 'preempted' if state.preempt_requested() else 'ok'


def serve(state, ud):
    note(state.preempt_requested())
    if state.preempt_requested():
        state.service_preempt()
        return 'preempted'


def serve_ok(state, ud):
    note(state.preempt_requested())
    state.service_preempt()


def asks(state, ud):
    QUIRKS['request'](state)
    note(state.preempt_requested())


def asks_and_serves(state, ud):
    QUIRKS['request'](state)
    note(state.preempt_requested())
    state.service_preempt()


def says(outcome):
    def work(state, ud):
        note(outcome)
        return outcome
    return work


def fails(state, ud):
    note('fails')
    return 1 / 0


def counts(state, ud):
    state.n = getattr(state, 'n', 0) + 1
    note(state.n)
    return 'ok' if state.n == 3 else 'again'


"""

ONE = """def build():
    sm = smach.StateMachine({outcomes})
    {before}
    with sm:
        smach.StateMachine.add('A', {state}{more})
    {after}
    return sm
"""


def one(state, outcomes="['ok']", more="", before="pass", after="pass", functions=""):
    """Return a machine of one state."""
    return functions + ONE.format(state=state, outcomes=outcomes, more=more, before=before, after=after)


def user_data(line, state):
    """Return a machine whose state does one thing with its userdata."""
    work = f"def work(state, r):\n    {line}\n\n\n"
    return one(state, before="sm.userdata.o = Obj()", after="sm.userdata.x = 2; sm.userdata.q = [1]", functions=work)


READS = "Does(work, inputs=['o', 'q'])"
PREEMPTED = "['ok', 'preempted']"

# (rows, how often a preempt is requested before, upstream's result, source)
PROBES = [
    ((1,), 0, "ok", user_data("note(r.o.v, caught(lambda: r.o.m()), type(r.o).__name__)", READS)),
    ((2,), 0, "ok", user_data("c = r.o; c.v = 5; note(c.v, r.o.v)", READS)),
    ((3,), 0, "ok", user_data("note(caught(lambda: delattr(r.o, 'v')))", READS)),
    ((4,), 0, "ok", user_data("r.q.append(2); note(r.q)", READS)),
    ((5,), 0, "ok", user_data("note(isinstance(r.o, Obj))", READS)),
    ((11, 44), 0, "ok", user_data("note(caught(lambda: r.nothing))", READS)),
    ((12,), 0, "ok", user_data("r.y = 1; note('y' in r)", READS)),
    ((13,), 0, "ok", user_data("r.x = 1; note('x' in r, caught(lambda: r.x))", "Does(work, outputs=['x'])")),
    ((28,), 0, ERROR, one("Does(fails)")),
    (
        (29,),
        0,
        ERROR,
        """def build():
    sm = smach.StateMachine(['ok'])
    inner = smach.StateMachine(['ok'])
    with inner:
        smach.StateMachine.add('A', Does(says('zz')))
    with sm:
        smach.StateMachine.add('IN', inner)
    return sm
""",
    ),
    ((31,), 0, ERROR, one("Does(says('zz'))")),
    (
        (32,),
        0,
        "ok",
        one("Does(counts, ['again', 'ok'])", "['ok', 'A']", ", {'again': 'A', 'ok': 'ok'}"),
    ),
    ((34,), 1, "preempted", one("Does(flag, ['ok', 'preempted'])", PREEMPTED)),
    ((35,), 1, "preempted", one("Does(serve, ['ok', 'preempted'])", PREEMPTED)),
    (
        (36,),
        0,
        "preempted",
        """def build():
    sm = smach.StateMachine(['ok', 'preempted'])
    with sm:
        smach.StateMachine.add('A', Does(asks), {'ok': 'B'})
        smach.StateMachine.add('B', Does(flag, ['ok', 'preempted']))
    return sm
""",
    ),
    (
        (37,),
        0,
        "ok",
        """def build():
    sm = smach.StateMachine(['ok', 'preempted'])
    with sm:
        smach.StateMachine.add('A', Does(asks_and_serves), {'ok': 'B'})
        smach.StateMachine.add('B', Does(flag, ['ok', 'preempted']))
    return sm
""",
    ),
    (
        (38,),
        0,
        "ok",
        """def build():
    sm = smach.StateMachine(['ok'])
    inner = smach.StateMachine(['ok'], input_keys=['a'], output_keys=['b'])
    with inner:
        smach.StateMachine.add('A', Does(lambda state, ud: note('a' in ud), inputs=['a'], outputs=['b']))
    with sm:
        smach.StateMachine.add('IN', inner)
    return sm
""",
    ),
    ((43,), 0, ERROR, one("Does(lambda state, ud: note(ud.x), inputs=['x'])")),
    (
        (46,),
        0,
        "ok",
        """def build():
    sm = smach.StateMachine(['ok'])
    with sm:
        smach.StateMachine.add_auto('A', Does(says('ok')), ['ok'])
        smach.StateMachine.add('B', Does(ok))
    return sm
""",
    ),
    (
        (47,),
        0,
        "ok",
        """def build():
    sm = smach.StateMachine(['ok', 'x'])
    with sm:
        smach.StateMachine.add_auto('A', Does(says('ok')), ['ok'], {'ok': 'x'})
        smach.StateMachine.add('B', Does(ok))
    return sm
""",
    ),
    (
        (48,),
        0,
        "ok",
        """def build():
    sm = smach.StateMachine(['ok'])
    sm.set_initial_state(['B'])
    with sm:
        smach.StateMachine.add('A', Does(says('a'), ['a']), {'a': 'B'})
        smach.StateMachine.add('B', Does(ok))
    return sm
""",
    ),
    ((50,), 0, ERROR, one("Returns(ok)")),
    (
        (51,),
        0,
        "fail",
        """def build():
    sm = smach.Sequence(['ok', 'fail'], 'ok')
    with sm:
        smach.Sequence.add('A', Does(ok, ['ok', 'fail']))
        smach.Sequence.add('B', Does(counts, ['ok', 'again']), {'again': 'A'})
        smach.Sequence.add('C', Does(says('fail'), ['ok', 'fail']))
    return sm
""",
    ),
    (
        (78,),
        0,
        "d2",
        """def build():
    it = smach.Iterator(['ok', 'd2'], [], [], it=[1, 2, 3], it_label='x', exhausted_outcome='done')
    with it:
        smach.Iterator.set_contained_state(
            'A', Does(lambda s, ud: note(ud.x), inputs=['x']), loop_outcomes=['ok'], final_outcome_map={'done': 'd2'}
        )
    return it
""",
    ),
    (
        (74,),
        0,
        "ok",
        """def build():
    it = smach.Iterator(['ok'], [], [], it=[1, 2, 3], it_label='x', exhausted_outcome='done')
    with it:
        smach.Iterator.set_contained_state('A', Does(lambda s, ud: note(ud.x), inputs=['x']))
    return it
""",
    ),
    (
        (79,),
        0,
        "ok",
        """def build():
    it = smach.Iterator(['ok'], [], [], it=[1, 2, 3], it_label='x', exhausted_outcome='done')
    with it:
        smach.Iterator.set_contained_state('A', Does(asks), loop_outcomes=['ok'])
    return it
""",
    ),
    (
        (80,),
        0,
        ERROR,
        """def build():
    it = smach.Iterator(['ok'], [], [], it=[1, 2, 3], it_label='x', exhausted_outcome='done')
    with it:
        smach.Iterator.set_contained_state('A', Does(fails), loop_outcomes=['ok'])
    return it
""",
    ),
    ((82,), 0, "ok", one("Does(lambda s, ud: note(ud.k), inputs=['k'])", more=", constants={'k': 3}")),
    (
        (83,),
        0,
        "ok",
        one("Does(lambda s, ud: note(ud.k), inputs=['k'])", more=", remapping={'k': 'kk'}, constants={'kk': 3}"),
    ),
    ((93,), 0, "ok", one("Does(ok)", more=", {'ok': ''}")),
]


def together(children, given, outcomes="['a', 'b', 'c', 'preempted']"):
    """Return a Concurrence."""
    adds = "".join(f"        smach.Concurrence.add({label!r}, {state})\n" for label, state in children.items())
    return f"def build():\n    cc = smach.Concurrence({outcomes}, 'a'{given})\n    with cc:\n{adds}    return cc\n"


TWO = {"A": "Does(ok)", "B": "Does(ok)"}
PROBES += [
    ((58,), 0, "a", together({"A": "Does(ok)"}, ", outcome_map={'b': {'A': 'zz'}}")),
    ((60,), 0, ERROR, together({"A": "Does(fails)", "B": "Does(ok)"}, "")),
    ((61,), 0, ERROR, together({"A": "Returns(ok)", "B": "Does(ok)"}, "")),
    ((65,), 0, ERROR, together(TWO, ", outcome_cb=lambda ends: 1 / 0")),
    ((62,), 0, ERROR, together(TWO, ", child_termination_cb=lambda ends: 1 / 0")),
    ((68,), 1, "preempted", together({"A": "Does(flag, ['ok', 'preempted'])"}, "")),
    ((69,), 0, "a", together({"A": "Does(asks)"}, "")),
    ((70,), 0, "c", together(TWO, ", outcome_map={'b': {'A': 'ok'}, 'c': {'A': 'ok', 'B': 'ok'}}")),
    ((70,), 0, "c", together(TWO, ", outcome_map={'c': {'A': 'ok', 'B': 'ok'}, 'b': {'A': 'ok'}}")),
    ((71,), 0, "a", together({"A": "Does(ok)"}, ", outcome_map={'b': {}}")),
]

# Rows that no form of a task can show, and why.
ELSEWHERE = {
    "the classes of userdata and states by themselves, which the legacy file makes": (
        7,
        8,
        9,
        10,
        15,
        16,
        17,
        18,
        19,
        20,
    ),
    "what construction raises, with which the legacy file can't be imported either": (
        *(23, 24, 25, 26, 27, 45, 53, 54, 55, 56, 57, 72, 77, 87),
    ),
    "a machine that upstream finds inconsistent; the import says why": (21, 22, 59, 94, 95),
    "attributes of container objects, of which a task has none": (33, 76, 84, 85, 86, 88, 89, 90, 91, 92),
    "a second execution of one machine; each run of a task begins anew": (40,),
    "callbacks and the shutdown check of containers, which a task has no equivalent of": (41, 42),
    "a machine that executes itself": (49,),
    "interrupts end the program here, and pass through in smach_compat too": (30,),
    "unregistered outcomes and keys that SMACH lets pass: a task refuses them by name": (52, 63, 64, 81),
    "wrapping and order of keys seen through a remapping that names one key twice": (14,),
    "functions in userdata, and objects that a nested machine hands on wrapped": (6, 39),
    "covered by the corpus: Iterators known only at run time, and callbacks, run as they are": (66, 67, 75, 73),
}
