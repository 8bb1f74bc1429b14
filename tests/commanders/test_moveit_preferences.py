"""What a MoveIt configuration package says about planning is what an arm does, unless its project says otherwise."""

from __future__ import annotations

import json
import pickle

import pytest
import yaml
from robot_files import description_package, moveit_package

from grip_bt.app.project.folder import ArmConfig, find_project
from grip_bt.app.wiring.commanders import settings_of
from grip_bt.base.errors import UnknownNameError
from grip_bt.cli.__main__ import main
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import inspect_robot, load_robot
from grip_bt.commanders.description.robot import Preference

PLANNING = """planner_configs:
  Both: {type: geometric::RRTConnect}
  TRRTkConfigDefault: {type: geometric::TRRT}
  PRMkConfigDefault: {type: geometric::PRM}
  Bold: {type: geometric::RRT}
  Shy: {type: geometric::RRT}
manipulator:
  default_planner_config: DEFAULT
  planner_configs: [TRRTkConfigDefault, PRMkConfigDefault, Shy, Bold, Both]
"""
SCALING = "default_velocity_scaling_factor: 0.2\ndefault_acceleration_scaling_factor: 0.1\n"


def package(folder, planner="PRMkConfigDefault", plugin="trac_ik_kinematics_plugin/TRAC_IKKinematicsPlugin"):
    description_package(folder)
    config = moveit_package(folder, 2) / "config"
    (config / "ompl_planning.yaml").write_text(PLANNING.replace("DEFAULT", planner))
    (config / "kinematics.yaml").write_text(f"manipulator: {{kinematics_solver: {plugin}}}\n")
    limits = config / "joint_limits.yaml"
    limits.write_text(SCALING + limits.read_text())
    return config.parent


def robot(folder):
    return load_robot(RobotConfig(moveit="smally_moveit_config"), folder)


def test_the_packages_choices_are_those_of_an_arm_that_says_nothing(tmp_path):
    package(tmp_path)
    settings = settings_of(ArmConfig(group="manipulator"), robot(tmp_path), seed=3)
    assert (settings.planner, settings.kinematics) == ("PRM", "trac_ik")
    assert (settings.speed, settings.acceleration, settings.seed) == (0.2, 0.1, 3)


def test_what_the_project_says_comes_first(tmp_path):
    package(tmp_path)
    arm = ArmConfig(group="manipulator", planner="RRTConnect", kinematics="damped_least_squares", speed=0.5)
    settings = settings_of(arm, robot(tmp_path), seed=0)
    assert (settings.planner, settings.kinematics, settings.speed) == ("RRTConnect", "damped_least_squares", 0.5)
    assert settings.acceleration == 0.1


def test_a_solver_that_is_not_there_is_told_before_anything_is_asked(tmp_path):
    package(tmp_path)
    with pytest.raises(UnknownNameError, match="'trac'; did you mean 'trac_ik'"):
        settings_of(ArmConfig(group="manipulator", kinematics="trac"), robot(tmp_path), seed=0)


def test_the_planner_of_a_group_is_the_one_of_its_moveit_package(tmp_path):
    package(tmp_path)
    (tmp_path / "grip.yaml").write_text(
        "grip: 1\nrobot: {moveit: smally_moveit_config}\narms: {a: {group: manipulator}}\n"
    )
    assert settings_of(find_project(tmp_path).file.arms["a"], robot(tmp_path), seed=0).planner == "PRM"


def test_what_is_not_here_is_said_and_the_usual_taken(tmp_path):
    package(tmp_path, "TRRTkConfigDefault", "bio_ik/BioIKKinematicsPlugin")
    made = robot(tmp_path)
    preferred = made.preferences["manipulator"]["planner"]
    assert preferred == Preference(None, "ompl_planning.yaml", "TRRT")
    settings = settings_of(ArmConfig(group="manipulator"), made, seed=0)
    assert (settings.planner, settings.kinematics) == ("RRTConnect", "damped_least_squares")


def test_without_a_default_rrt_connect_is_taken(tmp_path):
    package(tmp_path, '""', "kdl_kinematics_plugin/KDLKinematicsPlugin")
    preferred = robot(tmp_path).preferences["manipulator"]
    assert (preferred["planner"].value, preferred["kinematics"].value) == ("RRTConnect", "damped_least_squares")


def test_preferences_follow_their_group_into_a_world_of_several_robots(tmp_path):
    package(tmp_path)
    two = {side: {"robot": {"moveit": "smally_moveit_config"}, "xyz": [0, y, 0]} for side, y in (("a", 1), ("b", -1))}
    made = load_robot(RobotConfig.model_validate({"name": "pair", "robots": two}), tmp_path)
    assert made.preferences["b_manipulator"]["planner"].value == "PRM"
    assert pickle.loads(pickle.dumps(made)) == made


def test_a_factor_that_is_none_is_an_error_with_its_file(tmp_path):
    config = package(tmp_path) / "config" / "joint_limits.yaml"
    config.write_text(config.read_text().replace("factor: 0.2", "factor: 2"))
    found = inspect_robot(str(tmp_path / "smally_moveit_config")).findings
    assert [f.code for f in found if "default_velocity_scaling_factor" in f.message] == ["bad-file"]


def test_show_prints_what_is_in_force_and_where_it_comes_from(tmp_path, capsys):
    folder = package(tmp_path, plugin="bio_ik/BioIKKinematicsPlugin")
    assert main(["robot", "show", str(folder)]) == 0
    told = yaml.safe_load(capsys.readouterr().out)["preferences"]["manipulator"]
    assert (told["planner"]["value"], told["planner"]["source"]) == ("PRM", "ompl_planning.yaml")
    assert told["kinematics"] == {"source": "kinematics.yaml", "unknown": "bio_ik/BioIKKinematicsPlugin"}
    assert told["speed"] == {"value": 0.2, "source": "joint_limits.yaml"}
    assert main(["robot", "show", str(folder), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["preferences"]["manipulator"]
    assert shown["planner"] == {
        "value": "PRM",
        "source": "ompl_planning.yaml",
        "unknown": "",
    }


def test_robots_that_are_no_package_prefer_nothing(tmp_path):
    description_package(tmp_path)
    made = load_robot(RobotConfig(urdf="smally_description/urdf/smally.urdf"), tmp_path)
    assert made.preferences == {}
    with pytest.raises(TypeError):
        made.preferences["x"] = {}
