import pytest
from ceiling_room import still_rig, three_cameras


@pytest.fixture(scope="module")
def pair():
    return three_cameras()


@pytest.fixture(scope="module")
def rig(pair):
    return still_rig(pair)
