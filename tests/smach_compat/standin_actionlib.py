"""actionlib of the ROS 1 stand-in: clients and servers of one process, each with threads of its own."""

import queue
import threading
import time

from standin_rospy import Duration, is_shutdown, master, resolved


class GoalStatus:
    PENDING, ACTIVE, PREEMPTED, SUCCEEDED, ABORTED, REJECTED, PREEMPTING, RECALLING, RECALLED, LOST = range(10)


_ENDED = {GoalStatus.PREEMPTED, GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.LOST}


class GoalHandle:
    """One goal, for both sides."""

    def __init__(self, goal, result_class, done, feedback):
        self._goal, self._result_class, self._done, self._feedback = goal, result_class, done, feedback
        self.status, self.result, self.ended = GoalStatus.PENDING, None, threading.Event()
        self.cancel_requested = False

    def get_goal(self):
        return self._goal

    def publish_feedback(self, feedback):
        if self._feedback is not None:
            self._feedback(feedback)

    def set_accepted(self, text=""):
        self.status = GoalStatus.ACTIVE

    def _end(self, status, result):
        if self.status in _ENDED:
            return
        self.result = self._result_class() if result is None else result
        self.status = status
        if self._done is not None:
            self._done(status, self.result)
        self.ended.set()

    def set_succeeded(self, result=None, text=""):
        self._end(GoalStatus.SUCCEEDED, result)

    def set_aborted(self, result=None, text=""):
        self._end(GoalStatus.ABORTED, result)

    def set_rejected(self, result=None, text=""):
        self._end(GoalStatus.REJECTED, result)

    def set_canceled(self, result=None, text=""):
        self._end(GoalStatus.PREEMPTED, result)


class ActionServer:
    def __init__(self, ns, ActionSpec, goal_cb, cancel_cb=None, auto_start=True):
        self._name, self.spec = resolved(ns), ActionSpec
        self._goal_cb, self._cancel_cb = goal_cb, cancel_cb or (lambda handle: None)
        self._events = queue.SimpleQueue()
        if auto_start:
            self.start()

    def start(self):
        threading.Thread(target=self._work, name=f"standin {self._name}", daemon=True).start()
        master.actions[self._name] = self

    def _work(self):
        while True:
            callback, handle = self._events.get()
            callback(handle)

    def take(self, handle):
        self._events.put((self._goal_cb, handle))

    def cancel(self, handle):
        handle.cancel_requested = True
        self._events.put((self._cancel_cb, handle))


class SimpleActionServer:
    """One goal at a time; a newer one preempts the current one and waits for its end."""

    def __init__(self, name, ActionSpec, execute_cb=None, auto_start=True):
        self._execute, self._preempt = execute_cb, lambda: None
        self._current, self._asked = None, threading.Event()
        self._goals = queue.SimpleQueue()
        self._server = ActionServer(name, ActionSpec, self._goal, self._cancel, auto_start=False)
        if auto_start:
            self.start()

    def start(self):
        threading.Thread(target=self._work, name="standin execute", daemon=True).start()
        self._server.start()

    def register_preempt_callback(self, callback):
        self._preempt = callback

    def _goal(self, handle):
        self._goals.put(handle)
        if self._current is not None:
            self._ask()

    def _cancel(self, handle):
        if handle is self._current:
            self._ask()

    def _ask(self):
        self._asked.set()
        self._preempt()

    def _work(self):
        while True:
            handle = self._goals.get()
            self._asked.clear()
            handle.set_accepted()
            self._current = handle
            if handle.cancel_requested:
                self._ask()
            self._execute(handle.get_goal())
            if not handle.ended.is_set():
                handle.set_aborted()
            self._current = None

    def is_preempt_requested(self):
        return self._asked.is_set()

    def publish_feedback(self, feedback):
        self._current.publish_feedback(feedback)

    def set_succeeded(self, result=None, text=""):
        self._current.set_succeeded(result)

    def set_aborted(self, result=None, text=""):
        self._current.set_aborted(result)

    def set_preempted(self, result=None, text=""):
        self._current.set_canceled(result)


class SimpleActionClient:
    def __init__(self, ns, ActionSpec):
        self._name, self._spec, self._handle = resolved(ns), ActionSpec, None

    def wait_for_server(self, timeout=None):
        limit = float("inf") if timeout is None or not timeout else timeout.to_sec()
        deadline = time.monotonic() + limit
        while self._name not in master.actions:
            if is_shutdown() or time.monotonic() > deadline:
                return False
            time.sleep(0.005)
        return True

    def send_goal(self, goal, done_cb=None, active_cb=None, feedback_cb=None):
        result_class = type(self._spec().action_result.result)
        self._handle = GoalHandle(goal, result_class, done_cb, feedback_cb)
        server = master.actions.get(self._name)
        if server is not None:
            server.take(self._handle)

    def cancel_goal(self):
        server = master.actions.get(self._name)
        if server is not None:
            server.cancel(self._handle)

    def wait_for_result(self, timeout=None):
        return self._handle.ended.wait(timeout.to_sec() if isinstance(timeout, Duration) and timeout else None)

    def send_goal_and_wait(self, goal, execute_timeout=None, preempt_timeout=None):
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            self.cancel_goal()
            self.wait_for_result(preempt_timeout)
        return self.get_state()

    def get_state(self):
        return GoalStatus.LOST if self._handle is None else self._handle.status

    def get_result(self):
        return self._handle.result
