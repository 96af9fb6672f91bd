"""The picture of all pieces: shading sees what it should, the sheet is written whole."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from circumspect.errors import OutputError
from circumspect.furniture import CATEGORIES
from circumspect.furniture.contact_sheet import draw_contact_sheet
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.furniture.placement import joined, turned
from circumspect.furniture.primitives import box, cylinder
from circumspect.furniture.shading import shaded


def test_a_piece_fills_its_picture_on_white():
    picture = shaded(box((1.0, 1.0, 1.0)), 60)
    assert picture.shape == (60, 60, 3)
    assert (picture[0, 0] == 1).all()
    drawn = (picture < 1).any(axis=2)
    rows, columns = np.nonzero(drawn)
    assert max(np.ptp(rows), np.ptp(columns)) >= 53
    assert picture[30, 30].max() < 1


def test_the_near_hides_the_far():
    near = box((4.0, 0.1, 4.0), (0.0, -1.0, 0.0))
    far = cylinder(0.1, 1.0, (1.0, 1.5, 1.5))
    both = shaded(turned(joined([near, far]), -0.7), 60)
    back_to_front = shaded(turned(joined([far, near]), -0.7), 60)
    np.testing.assert_allclose(both, back_to_front)
    hidden = shaded(turned(joined([near, box((0.01, 0.01, 0.01), (1.0, 1.5, 1.5))]), -0.7), 60)
    np.testing.assert_allclose(both, hidden)


def test_top_front_and_side_of_a_box_differ_in_brightness():
    picture = shaded(box((1.0, 1.0, 1.0)), 90)
    tones, counts = np.unique(picture[..., 0].round(3), return_counts=True)
    assert (counts[tones < 1] > 300).sum() == 3


def test_sheet_has_a_row_a_category(tmp_path):
    draw_contact_sheet(tmp_path / "sheet.png", columns=2, pixels=24)
    with Image.open(tmp_path / "sheet.png") as image:
        pixels = np.asarray(image)
    assert pixels.shape[0] == 24 * len(CATEGORIES)
    for row in range(len(CATEGORIES)):
        for column in range(2):
            left = pixels.shape[1] - 24 * (2 - column)
            assert (pixels[24 * row : 24 * row + 24, left : left + 24] < 250).any()


def test_sheet_that_can_not_be_written_is_an_output_error(tmp_path):
    with pytest.raises(OutputError, match="is a folder"):
        draw_contact_sheet(tmp_path, columns=1, pixels=12)


def test_package_imports_without_matplotlib_or_pillow():
    code = (
        "import sys, circumspect.furniture, circumspect.furniture.contact_sheet as s; "
        "print(sorted({'matplotlib', 'PIL', 'torch', 'trimesh'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_module_without_a_file_says_what_to_give():
    command = [sys.executable, "-m", "circumspect.furniture.contact_sheet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "give one file to write" in done.stderr


@pytest.mark.parametrize("kind", OTHER_THINGS)
def test_other_things_stand_on_the_floor_and_differ(kind):
    one, other = make_other_thing(kind, 0), make_other_thing(kind, 1)
    low, high = one.vertices_xyz.min(axis=0), one.vertices_xyz.max(axis=0)
    np.testing.assert_allclose([*(low + high)[:2], low[2]], 0, atol=1e-9)
    assert 0.2 < (high - low).max() < 6
    assert not np.array_equal(one.vertices_xyz, other.vertices_xyz)
    np.testing.assert_array_equal(one.vertices_xyz, make_other_thing(kind, 0).vertices_xyz)
