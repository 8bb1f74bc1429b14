"""`ActionServerWrapper`: a container offered as an action server."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Mapping
from typing import Any

from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.user_data import NOTHING, Remapper, UserData

from ._connection import fields, ros, with_optional_node

__all__ = ["ActionServerWrapper"]


class ActionServerWrapper:
    """Executes a container for each goal; its outcome decides how the goal ends: `aborted`, where it is in no list.

    The container finds the goal, the result to fill and the feedback in its userdata under `goal_key`, `result_key` and
    `feedback_key`, if it registers them as input keys (profile `ros2` registers them itself). `..._slots_map` are field
    -> userdata; that of the feedback has no effect, as upstream. `expand_goal_slots` and `pack_result_slots` take all
    fields, for userdata of the same names.
    """

    @with_optional_node
    def __init__(
        self,
        server_name: str,
        action_spec: Any,
        wrapped_container: Any,
        succeeded_outcomes: list[str] = NOTHING,
        aborted_outcomes: list[str] = NOTHING,
        preempted_outcomes: list[str] = NOTHING,
        goal_key: str = "action_goal",
        feedback_key: str = "action_feedback",
        result_key: str = "action_result",
        goal_slots_map: Mapping[str, str] | None = None,
        feedback_slots_map: Mapping[str, str] | None = None,
        result_slots_map: Mapping[str, str] | None = None,
        expand_goal_slots: bool = False,
        pack_result_slots: bool = False,
    ):
        self.wrapped_container = wrapped_container
        wrapped_container.register_transition_cb(self.transition_cb)
        wrapped_container.register_termination_cb(self.termination_cb)
        self.userdata = UserData()
        self._goal_key, self._feedback_key, self._result_key = goal_key, feedback_key, result_key
        self._goal_slots_map, self._result_slots_map = goal_slots_map or {}, result_slots_map or {}
        self._expand_goal_slots, self._pack_result_slots = expand_goal_slots, pack_result_slots
        self.userdata[goal_key] = action_spec.Goal()
        self.userdata[result_key] = action_spec.Result()
        self.userdata[feedback_key] = action_spec.Feedback()
        self._server_name, self._action_spec = server_name, action_spec
        self._succeeded_outcomes, self._aborted_outcomes = set(succeeded_outcomes), set(aborted_outcomes)
        self._preempted_outcomes = set(preempted_outcomes)
        sets = (self._succeeded_outcomes, self._aborted_outcomes, self._preempted_outcomes)
        if len(set().union(*sets)) != sum(map(len, sets)):
            hooks.logerr(f"The succeeded, aborted and preempted outcomes of {self._server_name!r} overlap: {sets}")

        name = ros().name_of(server_name, self._node)  # type: ignore[attr-defined]  # set by with_optional_node
        self._started = False
        self._starting = threading.Lock()
        self._action_server = ros().action_server(name, action_spec, self.execute_cb, self.preempt_cb)
        if settings.ros2:
            wrapped_container.register_input_keys([goal_key, result_key, feedback_key])
            self.run_server()

    def run_server(self) -> None:
        """Take goals from now on; doesn't block. Harmless when it does already."""
        with self._starting:
            if self._started:
                return
            self._started = True
        self._action_server.start()
        hooks.loginfo(f"A state machine serves the action {self._server_name!r}")

    def transition_cb(self, userdata: object, active_states: list[str]) -> None:
        self.publish_feedback(userdata)

    def termination_cb(self, userdata: object, terminal_states: object, container_outcome: str) -> None:
        hooks.logdebug(f"The wrapped container ended in {terminal_states} with {container_outcome!r}")

    def publish_feedback(self, userdata: Any) -> None:
        """Send what is under `feedback_key`; nothing when the container has no such userdata."""
        if self._feedback_key in userdata:  # upstream raises, and its container logs that at each transition
            self._action_server.feedback(userdata[self._feedback_key])

    def execute_cb(self, goal: Any) -> None:
        if self._expand_goal_slots:
            for slot in fields(goal):
                self.userdata[slot] = getattr(goal, slot)
                if settings.ros2:
                    self.wrapped_container.register_input_keys([slot])
        self.userdata[self._goal_key] = goal
        for slot, key in self._goal_slots_map.items():
            self.userdata[key] = getattr(goal, slot)
        container = self.wrapped_container
        try:
            inputs, outputs = container.get_registered_input_keys(), container.get_registered_output_keys()
            outcome = container.execute(Remapper(self.userdata, inputs, outputs, {}))
            result = self._result()
        except Exception:  # noqa: BLE001 - whatever it was, the client gets an end of its goal
            hooks.logerr(f"Executing the container of {self._server_name!r} raised: {traceback.format_exc()}")
            self._action_server.end("aborted")
            return
        preempted = "preempted" if outcome in self._preempted_outcomes else "aborted"
        self._action_server.end("succeeded" if outcome in self._succeeded_outcomes else preempted, result)

    def _result(self) -> object:
        result = self.userdata[self._result_key]
        for slot, key in self._result_slots_map.items():
            setattr(result, slot, self.userdata[key])
        if self._pack_result_slots:
            for slot in fields(result):
                if slot in self.userdata:
                    setattr(result, slot, self.userdata[slot])
        return result

    def preempt_cb(self) -> None:
        hooks.loginfo(f"Preempt of the state machine behind {self._server_name!r} requested")
        self.wrapped_container.request_preempt()
