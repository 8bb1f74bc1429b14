"""A small robot's files, as a user would have them: an arm of six joints and a gripper of two fingers."""

from __future__ import annotations

from pathlib import Path

AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
RISES = ("0 0 0.2", "0 0 0.1", "0 0 0.35", "0 0 0.1", "0 0 0.25", "0 0 0.08")
JOINTS = tuple(f"j{k}" for k in range(1, 7))
INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'


def body(name: str, shape: str, prefix: str = "", z: float = 0.04) -> str:
    collision = f'<collision><origin xyz="0 0 {z}"/><geometry>{shape}</geometry></collision>'
    return f'<link name="{prefix}{name}">{INERTIAL}{collision}</link>\n'


def joint(name: str, kind: str, parent: str, child: str, xyz: str, more: str = "", prefix: str = "") -> str:
    return (
        f'<joint name="{prefix}{name}" type="{kind}"><parent link="{prefix}{parent}"/><child link="{prefix}{child}"/>'
        f'<origin xyz="{xyz}"/>{more}</joint>\n'
    )


def limits(lower: float, upper: float, velocity: float = 2.0) -> str:
    return f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="80"/>'


def urdf(name: str = "smally", prefix: str = "", mesh: str = "") -> str:
    """Return the robot; with `mesh`, its base has that mesh for a shape."""
    base = f'<mesh filename="{mesh}"/>' if mesh else '<cylinder radius="0.06" length="0.1"/>'
    text = f'<?xml version="1.0"?>\n<robot name="{name}">\n' + body("base", base, prefix)
    for k, (axis, rise) in enumerate(zip(AXES, RISES, strict=True), 1):
        parent = "base" if k == 1 else f"l{k - 1}"
        text += body(f"l{k}", '<box size="0.05 0.05 0.05"/>', prefix)
        text += joint(f"j{k}", "revolute", parent, f"l{k}", rise, f'<axis xyz="{axis}"/>{limits(-2.8, 2.8)}', prefix)
    text += body("palm", '<box size="0.06 0.1 0.03"/>', prefix, 0.015)
    text += joint("wrist_to_palm", "fixed", "l6", "palm", "0 0 0.07", prefix=prefix)
    for side, sign in (("left", 1), ("right", -1)):
        follow = f'<mimic joint="{prefix}slide_left"/>' if side == "right" else ""
        text += body(side, '<box size="0.02 0.01 0.06"/>', prefix, 0.06)
        slide = f'<axis xyz="0 {sign} 0"/>{limits(0.0, 0.04, 0.2)}{follow}'
        text += joint(f"slide_{side}", "prismatic", "palm", side, f"0 {sign * 0.01} 0", slide, prefix)
    return text + "</robot>\n"


SRDF = """<?xml version="1.0"?>
<robot name="smally">
  <virtual_joint name="stand" type="fixed" parent_frame="world" child_link="base"/>
  <group name="manipulator"><chain base_link="base" tip_link="l6"/></group>
  <group name="gripper"><joint name="slide_left"/><joint name="slide_right"/></group>
  <group name="all"><group name="manipulator"/><group name="gripper"/></group>
  <group_state name="home" group="manipulator">
    <joint name="j1" value="0"/><joint name="j2" value="0.5"/><joint name="j3" value="1.0"/>
    <joint name="j4" value="0"/><joint name="j5" value="1.2"/><joint name="j6" value="0"/>
  </group_state>
  <group_state name="open" group="gripper"><joint name="slide_left" value="0.04"/></group_state>
  <group_state name="closed" group="gripper"><joint name="slide_left" value="0"/></group_state>
  <end_effector name="hand" parent_link="l6" group="gripper"/>
  <disable_collisions link1="l1" link2="l3" reason="Never"/>
</robot>
"""

XACRO = """<?xml version="1.0"?>
<robot name="smally" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <xacro:arg name="reach" default="0.35"/>
  <xacro:include filename="$(find smally_description)/urdf/parts.xacro"/>
  <xacro:parts prefix="$(arg prefix)" reach="$(arg reach)"/>
</robot>
"""
PARTS = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="parts" params="prefix reach">
    <link name="${prefix}base"/>
    <link name="${prefix}l1"><inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="${prefix}j1" type="revolute">
      <parent link="${prefix}base"/><child link="${prefix}l1"/><origin xyz="0 0 ${float(reach) * 2}"/>
      <axis xyz="0 0 1"/><limit lower="${-pi}" upper="${pi}" velocity="2" effort="10"/>
    </joint>
  </xacro:macro>
</robot>
"""

LIMITS = """joint_limits:
  j1: {has_velocity_limits: true, max_velocity: 1.25, has_acceleration_limits: true, max_acceleration: 3.5}
  j2: {has_velocity_limits: false, max_velocity: 0.1, has_position_limits: true,
    min_position: !degrees -90, max_position: 1.5}
"""
KINEMATICS = "manipulator: {kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin}\n"
OMPL = """planner_configs:
  RRTConnectkConfigDefault: {type: geometric::RRTConnect}
  ESTkConfigDefault: {type: geometric::EST}
manipulator:
  default_planner_config: RRTConnectkConfigDefault
  planner_configs: [RRTConnectkConfigDefault, ESTkConfigDefault]
"""
SENSORS = """sensors: [camera]
camera: {sensor_plugin: occupancy_map_monitor/PointCloudOctomapUpdater, point_cloud_topic: /camera/points}
"""


def description_package(folder: Path) -> Path:
    """Write the package `smally_description`: a URDF, and a xacro file that includes another."""
    package = folder / "smally_description"
    (package / "urdf").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>smally_description</name></package>")
    (package / "urdf" / "smally.urdf").write_text(urdf())
    (package / "urdf" / "smally.urdf.xacro").write_text(XACRO)
    (package / "urdf" / "parts.xacro").write_text(PARTS)
    return package


def moveit_package(folder: Path, ros: int) -> Path:
    """Write a MoveIt configuration package beside the description, in the layout of ROS 1 or ROS 2."""
    package = folder / "smally_moveit_config"
    config = package / "config"
    config.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>smally_moveit_config</name></package>")
    (config / "smally.srdf").write_text(SRDF)
    (config / "joint_limits.yaml").write_text(LIMITS)
    (config / "kinematics.yaml").write_text(KINEMATICS)
    (config / "ompl_planning.yaml").write_text(OMPL)
    (config / "sensors_3d.yaml").write_text(SENSORS)
    keys = ("URDF", "SRDF") if ros == 1 else ("urdf", "srdf")
    (package / ".setup_assistant").write_text(
        f"moveit_setup_assistant_config:\n  {keys[0]}:\n    package: smally_description\n"
        f"    relative_path: urdf/smally.urdf\n  {keys[1]}:\n    relative_path: config/smally.srdf\n"
    )
    if ros == 1:
        (package / "launch").mkdir()
        (package / "launch" / "move_group.launch").write_text("<launch/>")
    else:
        (config / "initial_positions.yaml").write_text("initial_positions: {j2: 0.7, slide_left: 0.02}\n")
    return package
