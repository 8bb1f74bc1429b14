"""Which adapters a run gets: fakes, simulation or ROS 2, commanders over them, components and messages."""
