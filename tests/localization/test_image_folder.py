from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from circumspect.errors import InputError
from circumspect.localization import CeilingImage, CharucoBoard, TagDetector, slots, tag_picture
from circumspect.localization.image_folder import ImageFolder, image_files, read_grey
from circumspect.localization.printed_page import print_page


def write_image(path, value=7, size=(8, 6), mode="L"):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new(mode, size, value).save(path)


def test_images_come_in_the_order_of_their_stamps(tmp_path):
    for name in ("b/0.100.png", "a/0.200.png", "a/0.0.png", "b/0.201.jpg"):
        write_image(tmp_path / name)
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / "empty").mkdir()
    folder = ImageFolder(tmp_path)
    assert folder.cameras == ("a", "b")
    assert len(folder) == 4
    assert [(i.camera, i.stamp) for i in folder] == [
        ("a", 0.0), ("b", 0.1), ("a", 0.2), ("b", 0.201),
    ]  # fmt: skip
    grouped = [[i.camera for i in slot] for slot in slots(folder, 0.03)]
    assert grouped == [["a"], ["b"], ["a", "b"]]


def test_stamps_are_read_from_a_file(tmp_path):
    write_image(tmp_path / "a" / "x.png")
    write_image(tmp_path / "a" / "y.png", (1, 2, 3), mode="RGB")
    (tmp_path / "a" / "stamps.txt").write_text("# name stamp\ny.png 1.5\nx.png 2.5\n")
    assert [i.stamp for i in ImageFolder(tmp_path)] == [1.5, 2.5]
    (tmp_path / "a" / "stamps.txt").write_text("y.png 1.5\n")
    with pytest.raises(InputError, match=r"no stamp of x\.png"):
        ImageFolder(tmp_path)
    (tmp_path / "a" / "stamps.txt").write_text("y.png soon\n")
    with pytest.raises(InputError, match="line 1"):
        ImageFolder(tmp_path)
    (tmp_path / "a" / "stamps.txt").write_text("y.png inf\n")
    with pytest.raises(InputError, match="finite"):
        ImageFolder(tmp_path)


def test_broken_images_are_skipped_and_reported(tmp_path):
    write_image(tmp_path / "a" / "1.png")
    (tmp_path / "a" / "2.png").write_bytes(b"no image")
    (tmp_path / "a" / "3.png").write_bytes((tmp_path / "a" / "1.png").read_bytes()[:40])
    Image.fromarray(np.zeros((4, 4), np.uint16)).save(tmp_path / "a" / "4.png")
    folder = ImageFolder(tmp_path)
    assert [i.stamp for i in folder] == [1.0]
    assert len(folder.skipped) == 3
    assert "8 bits" in folder.skipped[str(tmp_path / "a" / "4.png")]


def test_invalid_folders_are_refused(tmp_path):
    with pytest.raises(InputError, match="is not a folder"):
        ImageFolder(tmp_path / "gone")
    with pytest.raises(InputError, match="contains no sub-folder"):
        ImageFolder(tmp_path)
    write_image(tmp_path / "a" / "first.png")
    with pytest.raises(InputError, match="not a stamp in seconds"):
        ImageFolder(tmp_path)


def test_images_are_named_or_found_in_folders(tmp_path):
    write_image(tmp_path / "2.png")
    write_image(tmp_path / "1.png")
    assert [p.name for p in image_files([tmp_path])] == ["1.png", "2.png"]
    with pytest.raises(InputError, match="does not exist"):
        image_files([tmp_path / "3.png"])
    (tmp_path / "none").mkdir()
    with pytest.raises(InputError, match="no image was given"):
        image_files([tmp_path / "none"])


def test_ceiling_images_are_grey_and_have_a_time():
    grey = np.zeros((4, 4), np.uint8)
    with pytest.raises(InputError, match="grey"):
        CeilingImage("a", 0.0, np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(InputError, match="no time"):
        CeilingImage("a", float("nan"), grey)
    with pytest.raises(InputError, match="8 bits"):
        TagDetector().detect(np.zeros((4, 4)))
    with pytest.raises(InputError, match="decimate must be"):
        TagDetector(2.5)


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_pages_are_to_scale(tmp_path, kind):
    page = tmp_path / f"tag.{kind}"
    print_page(page, tag_picture(5), 0.18, "tag 5", arrow=True)
    assert page.stat().st_size > 2000
    if kind == "png":
        with Image.open(page) as image:
            assert image.info["dpi"] == pytest.approx((300, 300), abs=0.1)
            assert image.size == (2480, 3508)
        (found,) = TagDetector(4.0).detect(read_grey(page))
        assert found.tag_id == 5
        assert found.side_px * 0.0254 / 300 == pytest.approx(0.144, abs=1e-4)
        # As its makers print it: the first corner is the lower left one.
        assert found.corners_uv[0] == pytest.approx(
            [found.corners_uv[:, 0].min(), found.corners_uv[:, 1].max()], abs=2
        )
        np.testing.assert_allclose(found.centre_uv, found.corners_uv.mean(axis=0), atol=0.5)


def test_impossible_pages_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"\.png or \.pdf"):
        print_page(tmp_path / "a.gif", tag_picture(1), 0.1, "")
    with pytest.raises(InputError, match="dots"):
        print_page(tmp_path / "a.png", tag_picture(1), 0.1, "", dpi=1)
    with pytest.raises(InputError, match="too large"):
        print_page(tmp_path / "a.png", tag_picture(1), 9.0, "", dpi=1200)
    with pytest.raises(InputError, match="586"):
        tag_picture(587)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("what", [{"columns": 2}, {"rows": 90}, {"square": 0.0}])
def test_impossible_boards_are_refused(what):
    with pytest.raises(InputError):
        CharucoBoard(**what)
