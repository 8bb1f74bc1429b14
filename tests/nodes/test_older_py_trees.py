"""Calls that py_trees took before 2.2 make what today's calls make, and today's mean what they mean."""

from typing import Any

import pytest
from py_trees import behaviours, composites, decorators, idioms
from py_trees.behaviour import Behaviour
from py_trees.common import OneShotPolicy, ParallelPolicy, Status

from grip_bt.nodes.older_py_trees import older_calls

_NAMES: dict[str, Any] = {
    **vars(behaviours),
    **vars(composites),
    **vars(decorators),
    "idioms": idioms,
    "ParallelPolicy": ParallelPolicy,
    "OneShotPolicy": OneShotPolicy,
    "Status": Status,
}
_ONCE = "OneShotPolicy.ON_SUCCESSFUL_COMPLETION"
PAIRS = {
    "Sequence('s', [Success('a')])": "Sequence('s', True, [Success('a')])",
    "Sequence(children=[Success('a')])": "Sequence('Sequence', True, [Success('a')])",
    "Sequence('s', False, [Success('a')])": "Sequence('s', False, [Success('a')])",
    "Selector()": "Selector('Selector', False)",
    "Selector('s', blackbox_level=1)": "Selector('s', False)",
    "Parallel('p')": "Parallel('p', ParallelPolicy.SuccessOnAll())",
    "Parallel('p', ParallelPolicy.SUCCESS_ON_ONE, [Success('a')])": (
        "Parallel('p', ParallelPolicy.SuccessOnOne(), [Success('a')])"
    ),
    "Inverter(Success('a'))": "Inverter('Inverter', Success('a'))",
    "Inverter(Success('a'), 'i')": "Inverter('i', Success('a'))",
    "Inverter(child=Success('a'))": "Inverter('Inverter', Success('a'))",
    "Timeout(Success('a'), 't', 3.0)": "Timeout('t', Success('a'), 3.0)",
    "OneShot(Success('a'))": f"OneShot('OneShot', Success('a'), {_ONCE})",
    "Condition(Success('a'), 'c')": "Condition('c', Success('a'), Status.SUCCESS)",
    "SetBlackboardVariable('k', 3)": "SetBlackboardVariable('SetBlackboardVariable', 'k', 3, True)",
    "CheckBlackboardVariableExists('k')": "CheckBlackboardVariableExists('CheckBlackboardVariableExists', 'k')",
    "CheckBlackboardVariableExists('n', 'k')": "CheckBlackboardVariableExists('n', 'k')",
    "idioms.oneshot('n', 'k', Success('a'))": "idioms.oneshot(Success('a'), 'n', 'k')",
    "idioms.oneshot(variable_name='k', behaviour=Success('a'))": "idioms.oneshot(Success('a'), variable_name='k')",
    "TickCounter(3)": "TickCounter('TickCounter', 3, Status.SUCCESS)",
    "Retry('r', Success('a'), 3)": "Retry('r', Success('a'), 3)",
}


def said(behaviour: Behaviour) -> Any:
    plain = {n: v for n, v in vars(behaviour).items() if isinstance(v, str | int | float | Status | OneShotPolicy)}
    policy = type(getattr(behaviour, "policy", None)).__name__
    return type(behaviour), plain, policy, [said(child) for child in behaviour.children]


@pytest.mark.parametrize("older", PAIRS)
def test_older_calls_make_what_todays_make(older: str) -> None:
    with older_calls():
        made = eval(older, _NAMES)
    assert said(made) == said(eval(PAIRS[older], _NAMES))


@pytest.mark.parametrize("call", ["Inverter()", "Sequence('s', childern=[])", "Retry(Success('a'))"])
def test_what_no_py_trees_took_is_refused_as_ever(call: str) -> None:
    with older_calls(), pytest.raises(TypeError, match="missing|unexpected"):
        eval(call, _NAMES)
    with pytest.raises(TypeError):
        eval("Inverter(Success('a'))", _NAMES)


def test_a_class_of_composites_that_hands_on_what_it_was_given_is_made() -> None:
    class Reactive(composites.Composite):
        def __init__(self, name: str = "reactive", children: Any = None, *args: Any, **kwargs: Any):
            super().__init__(name, children, *args, **kwargs)

        def tick(self) -> Any:
            yield self

    with older_calls():
        assert Reactive(memory=False).name == "reactive"
