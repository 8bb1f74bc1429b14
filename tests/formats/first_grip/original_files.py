"""Files in the formats of the first GRIP, made here: a task in text form, and configuration."""

from __future__ import annotations

from pathlib import Path

PICK_AND_PLACE = """
name: pick
outcomes: [Task success, Task failure]
states:
  - try counter: {source: counter, initial_value: 0, end_value: 3, output: tries,
      transitions: {success: look, finished: Task failure}}
  - look: {source: Kinect2, sensor_topic: pointcloud, output: pc2,
      transitions: {success: grasping, failure: try counter}}
  - grasping: {source: BasicGrasping, input: pc2, output: grasp_pose,
      transitions: {'0': reach, '1': try counter, state_failure: Task failure}}
  - reach:
      source: state_machine
      outcomes: [success, failure]
      transitions: {success: both, failure: try counter}
      states:
        - plan: {source: plan, group_name: panda_arm, target_state_name: grasp_pose,
            transitions: {success: move, fail: failure}}
        - move: {source: move, group_name: panda_arm, transitions: {success: success, fail: failure}}
  - both:
      source: concurrent_state_machine
      outcomes: [done, not_done]
      default_outcome: not_done
      outcome_map: {done: {plan home: success, reset: success}}
      transitions: {done: Task success, not_done: Task failure}
      states:
        - plan home: {source: plan, group_name: panda_arm, target_state_type: joint state,
            target_state_name: above_bin, plan_name: home}
        - reset: {source: reinitialise_managers}
"""
"""A nested machine, a concurrent one, planning, a sensor, a component and a counter."""
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


def write_configuration(folder: Path) -> None:
    """Write a robot's configuration; its files name others by paths of another computer."""
    (folder / "files").mkdir(parents=True)
    for name, text in CONFIGURATION.items():
        (folder / "files" / name).write_text(text)
