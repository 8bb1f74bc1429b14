import pytest
from table_top import robot_model

from grip_bt.commanders.kinematics.model import RobotModel


@pytest.fixture
def model() -> RobotModel:
    return robot_model()
