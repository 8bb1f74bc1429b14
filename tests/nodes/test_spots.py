import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grip_bt.base.values import Pose
from grip_bt.nodes.objects import Disc, Region, free_spots, opening_room, region_of

CRATE = Region(np.array([0.35, -0.55]), np.array([0.61, -0.25]), 0.0, 0.06)
discs = st.builds(Disc, st.floats(0.38, 0.58), st.floats(-0.52, -0.28), st.floats(0.02, 0.04))


def test_the_region_of_an_open_box_is_what_its_walls_leave(world):
    region = region_of(world.scene, "crate")
    np.testing.assert_allclose([*region.low, *region.high], [0.35, -0.55, 0.61, -0.25])
    assert (region.floor, region.rim) == (0.0, 0.06)
    assert region_of(world.scene, "basket") is None
    assert region_of(world.scene, "") is None


@given(st.lists(discs, max_size=4), st.floats(0.02, 0.05))
def test_spots_lie_within_the_walls_and_clear_of_what_stands_there(taken, radius):
    spots = free_spots(CRATE, radius, taken)
    assert np.all(spots >= CRATE.low + radius)
    assert np.all(spots <= CRATE.high - radius)
    for disc in taken:
        assert np.all(disc.distance(spots) > radius)
    gaps = [np.linalg.norm(a - b) for i, a in enumerate(spots) for b in spots[:i]]
    assert min(gaps, default=1) > 0.04


def test_the_first_spot_leaves_room_in_the_middle_and_the_next_is_far_from_it():
    first = free_spots(CRATE, 0.03, [])[0]
    second = free_spots(CRATE, 0.03, [Disc(*first, 0.03)])[0]
    assert np.linalg.norm(first - [0.48, -0.4]) > 0.1
    assert np.linalg.norm(first - second) > 0.15


def test_a_thing_that_is_too_large_has_no_spot():
    assert free_spots(CRATE, 0.13, []).shape == (0, 2)


def test_fingers_open_along_their_own_direction_in_front_of_the_palm():
    hand = Pose.from_matrix(np.array([[0, 0, 1, 0.4], [1, 0, 0, -0.4], [0, 1, 0, 0.1], [0, 0, 0, 1.0]]))
    # The palm looks along world x, the fingers point along world y.
    assert opening_room(hand, [Disc(0.4, -0.3, 0.03)]) < 0
    assert opening_room(hand, [Disc(0.47, -0.32, 0.03)]) < 0
    assert opening_room(hand, [Disc(0.4, -0.5, 0.03)]) > 0.05
    assert opening_room(hand, []) == 1
