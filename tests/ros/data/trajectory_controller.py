"""A joint trajectory controller, as ros2_control's follows trajectories.

Its state at a moment is that of the trajectory: a cubic spline where points have velocities, else straight. A goal that
comes while another one is followed takes its place at once, and the other one is given up; until the first point of the
new trajectory is due, the joints go there by a spline from the position and velocity that they have. On a cancel the
goal ends at once, and the joints then brake evenly, at `BRAKING` [rad/s^2]. A trajectory that ends beyond 3 rad is
given up half-way, as a path tolerance that is violated; one of other joints, or of points that don't lie after one
another, is rejected. Feedback tells where the joints should be. Joints go no further than `blocked`, where that is set;
they end short of their goal then, and it is given up. What comes by the topic `joint_trajectory` is followed likewise
and nobody is told of its end; what ends beyond 3 rad is passed over.
"""

import threading
import time
from types import SimpleNamespace

from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from trajectory_msgs.msg import JointTrajectory

PERIOD = 0.004
BRAKING = 4.0


def seconds(duration):
    return duration.sec + duration.nanosec * 1e-9


def spline(t0, p0, v0, t1, p1, v1, t):
    """Position and velocity at t of the cubic through both ends; straight where a velocity isn't known."""
    span = t1 - t0
    s = (t - t0) / span
    if v0 is None or v1 is None:
        return p0 + s * (p1 - p0), (p1 - p0) / span
    a, b = span * v0 - (p1 - p0), -span * v1 + (p1 - p0)
    position = (1 - s) * p0 + s * p1 + s * (1 - s) * ((1 - s) * a + s * b)
    speed = ((p1 - p0) + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)) / span
    return position, speed


class TrajectoryController:
    def __init__(self, node, name, joints, positions, lock, heard=True):
        self.joints, self.positions, self.lock = joints, positions, lock
        self.velocities = dict.fromkeys(joints, 0.0)
        self.latest, self.turn, self.blocked = None, threading.Lock(), None
        self.server = ActionServer(
            node,
            FollowJointTrajectory,
            f"{name}/follow_joint_trajectory",
            self.follow,
            goal_callback=self.accepts,
            handle_accepted_callback=self.taken,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        if heard:
            node.create_subscription(JointTrajectory, f"{name}/joint_trajectory", self.heard, 10)

    def taken(self, handle):
        self.latest = handle  # here, in the order of the goals: they are followed on threads, which begin in any order
        handle.execute()

    def heard(self, trajectory):
        asked = SimpleNamespace(trajectory=trajectory)
        beyond = any(abs(p) > 3 for point in trajectory.points for p in point.positions)
        if self.accepts(asked) == GoalResponse.ACCEPT and not beyond:
            untold = dict.fromkeys(("publish_feedback", "succeed", "abort", "canceled"), lambda *_: None)
            handle = SimpleNamespace(request=asked, is_cancel_requested=False, **untold)
            self.latest = handle
            threading.Thread(target=self.follow, args=(handle,), daemon=True).start()

    def accepts(self, goal):
        trajectory = goal.trajectory
        times = [seconds(p.time_from_start) for p in trajectory.points]
        ordered = bool(times) and all(b > a for a, b in zip(times, times[1:], strict=False))
        good = set(trajectory.joint_names) == set(self.joints) and ordered
        return GoalResponse.ACCEPT if good else GoalResponse.REJECT

    def follow(self, handle):
        with self.turn:  # the one before sees that it isn't the latest any more, and ends
            try:
                return self.followed(handle)
            finally:
                if self.latest is handle:
                    self.latest = None

    def followed(self, handle):
        trajectory, result = handle.request.trajectory, FollowJointTrajectory.Result()
        began, rows = time.monotonic(), self.points(trajectory)
        end = rows[-1][0]
        hopeless = max(abs(p) for p in trajectory.points[-1].positions) > 3
        while (now := time.monotonic() - began) < end:
            if handle.is_cancel_requested:
                handle.canceled()
                threading.Thread(target=self.brake, args=(handle,), daemon=True).start()
                return result
            if self.latest is not handle:
                result.error_code = result.INVALID_GOAL
                result.error_string = "Current goal cancelled due to new incoming action."
                handle.abort()
                return result
            if hopeless and now > end / 2:
                self.hold()
                result.error_code, result.error_string = result.PATH_TOLERANCE_VIOLATED, "joint_a is blocked"
                handle.abort()
                return result
            self.move(trajectory.joint_names, rows, now)
            feedback = FollowJointTrajectory.Feedback(joint_names=trajectory.joint_names)
            feedback.desired.positions = [self.positions[name] for name in trajectory.joint_names]
            handle.publish_feedback(feedback)
            time.sleep(PERIOD)
        goal = trajectory.points[-1].positions
        with self.lock:
            for name, position in zip(trajectory.joint_names, goal, strict=True):
                self.positions[name] = self.reachable(position)
        self.hold()
        if [self.reachable(position) for position in goal] == list(goal):
            handle.succeed()
        else:
            result.error_code, result.error_string = result.GOAL_TOLERANCE_VIOLATED, "something is in the way"
            handle.abort()
        return result

    def reachable(self, position):
        return position if self.blocked is None else min(position, self.blocked)

    def points(self, trajectory):
        """Time, positions and velocities of each point, those of now first where the first point is later."""
        rows = [(seconds(p.time_from_start), list(p.positions), list(p.velocities) or None) for p in trajectory.points]
        if rows[0][0] > 0:
            with self.lock:
                now = [self.positions[name] for name in trajectory.joint_names]
            speeds = [self.velocities[name] for name in trajectory.joint_names]
            rows.insert(0, (0.0, now, speeds if rows[0][2] is not None else None))
        return rows

    def move(self, names, rows, now):
        k = max(i for i, row in enumerate(rows) if row[0] <= now)
        (t0, p0, v0), (t1, p1, v1) = rows[k], rows[k + 1]
        with self.lock:
            for i, name in enumerate(names):
                ends = (None, None) if v0 is None or v1 is None else (v0[i], v1[i])
                position, self.velocities[name] = spline(t0, p0[i], ends[0], t1, p1[i], ends[1], now)
                self.positions[name] = self.reachable(position)

    def brake(self, handle):
        """Come to rest evenly, all joints at once; a newer goal takes over in the middle of that."""
        with self.lock:
            start, speeds = dict(self.positions), dict(self.velocities)
        takes = max((abs(speed) for speed in speeds.values()), default=0.0) / BRAKING
        began = time.monotonic()
        while not self.overtaken(handle) and (now := time.monotonic() - began) < takes:
            self.coast(start, speeds, now, takes)
            time.sleep(PERIOD)
        if not self.overtaken(handle):
            if takes:
                self.coast(start, speeds, takes, takes)
            self.hold()

    def overtaken(self, handle):
        return self.latest is not None and self.latest is not handle

    def coast(self, start, speeds, now, takes):
        with self.lock:
            for name in self.joints:
                self.positions[name] = self.reachable(start[name] + speeds[name] * (now - now**2 / (2 * takes)))
                self.velocities[name] = speeds[name] * (1 - now / takes)

    def hold(self):
        self.velocities.update(dict.fromkeys(self.joints, 0.0))
