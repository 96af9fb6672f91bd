"""Images of ceiling cameras in bags."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from bag_world import CAMERA, frames
from foreign_bags import mcap
from PIL import Image

from circumspect.errors import InputError
from circumspect.localization import CeilingImage, LensCamera
from circumspect.recording import CeilingBag, RunRecorder, open_bag
from circumspect.recording.image_messages import colour_message, grey_message, grey_of
from circumspect.recording.mcap_writer import McapWriter
from circumspect.recording.ros_time import header
from circumspect.recording.ros_types import COMPRESSED_IMAGE, IMAGE, message

LENS = LensCamera(CAMERA, (0.1, 0.0, 0.0, 0.0, -0.2))
NAMES = ("ceiling_0", "ceiling_1")


def picture(number: int) -> np.ndarray:
    return np.random.default_rng(number).integers(0, 256, (24, 32)).astype(np.uint8)


def compressed(pixels: np.ndarray, kind: str) -> object:
    held = io.BytesIO()
    Image.fromarray(pixels).save(held, kind)
    data = np.frombuffer(held.getvalue(), np.uint8)
    return message(COMPRESSED_IMAGE, header=header(1.0, "up"), format=kind.lower(), data=data)


def bag_of(path: Path, topics: dict[str, list[tuple[str, object]]]) -> Path:
    writer = McapWriter(path, {})
    for topic, messages in topics.items():
        for kind, one in messages:
            writer.write(topic, kind, 1_000_000_000, one)
    writer.close()
    return path


def test_recorded_ceiling_images_are_read_back(tmp_path: Path) -> None:
    recorder, given = RunRecorder(tmp_path / "run.mcap", {}), []
    for number, frame in enumerate(frames(3)):
        recorder.frame(frame)
        for camera in NAMES:
            given.append(CeilingImage(camera, frame.stamp, picture(len(given))))
            recorder.ceiling_image(given[-1], LENS)
        assert len(given) == 2 * number + 2
    recorder.close()
    images = CeilingBag(open_bag(tmp_path / "run.mcap"), [*NAMES, "ceiling_2"])
    assert (images.cameras, len(images)) == (NAMES, 6)
    for _ in range(2):
        read = list(images)
        assert [(i.camera, i.stamp) for i in read] == [(i.camera, i.stamp) for i in given]
        for one, other in zip(read, given, strict=True):
            np.testing.assert_array_equal(one.grey, other.grey)


def test_topics_of_other_names_need_a_choice(tmp_path: Path) -> None:
    path = bag_of(tmp_path / "a.mcap", {"/up/image": [(IMAGE, grey_message(picture(1), 1.0, "u"))]})
    images = CeilingBag(open_bag(path), ["ceiling_0"], {"ceiling_0": "/up/image"})
    assert [image.camera for image in images] == ["ceiling_0"]
    with pytest.raises(
        InputError, match=r"no image topic .*image topics: /up/image; choose .*--topic"
    ):
        CeilingBag(open_bag(path), ["ceiling_0"])
    with pytest.raises(InputError, match="/up/image is given for both ceiling_0 and ceiling_1"):
        CeilingBag(open_bag(path), NAMES, dict.fromkeys(NAMES, "/up/image"))
    with pytest.raises(
        InputError, match="/down of ceiling_0 is not an image topic; image topics: /up/image"
    ):
        CeilingBag(open_bag(path), ["ceiling_0"], {"ceiling_0": "/down"})


def test_raw_images_are_preferred_to_compressed_ones_and_two_raw_topics_are_refused(
    tmp_path: Path,
) -> None:
    raw, packed = (IMAGE, grey_message(picture(1), 1.0, "u")), compressed(picture(1), "PNG")
    both = {"/c/image_raw": [raw], "/c/image_raw/compressed": [(COMPRESSED_IMAGE, packed)]}
    assert list(CeilingBag(open_bag(bag_of(tmp_path / "a.mcap", both)), ["c"]).topics) == [
        "/c/image_raw"
    ]
    two = bag_of(tmp_path / "b.mcap", {"/c/image_raw": [raw], "/c/image_rect": [raw]})
    with pytest.raises(InputError, match=r"several topics may hold images of c: .*--topic c=TOPIC"):
        CeilingBag(open_bag(two), ["c"])


def test_a_broken_image_is_left_out_and_named(tmp_path: Path) -> None:
    short = grey_message(picture(1), 1.0, "c")
    short.data = short.data[:50]
    good = grey_message(picture(2), 1.1, "c")
    path = bag_of(tmp_path / "a.mcap", {"/c/image_raw": [(IMAGE, short), (IMAGE, good)]})
    images = CeilingBag(open_bag(path), ["c"])
    assert [image.stamp for image in images] == [1.1]
    assert "50 bytes" in images.skipped["/c/image_raw at 1.000 s"]


def test_a_message_that_is_no_image_is_left_out_and_counted(tmp_path: Path) -> None:
    good = ("/c/image_raw", IMAGE, 1.1, grey_message(picture(2), 1.1, "c"))
    images = CeilingBag(open_bag(mcap(tmp_path, [(*good[:3], b"garbage"), good])), ["c"])
    for _ in range(2):
        assert [image.stamp for image in images] == [1.1]
        assert images.skipped == {"messages on /c/image_raw": f"1 is not of type {IMAGE}"}


def test_grey_of_every_kind() -> None:
    grey = picture(3)
    np.testing.assert_array_equal(grey_of(grey_message(grey, 0.0, "c")), grey)
    colour = np.stack([grey, grey, grey], axis=-1)
    np.testing.assert_array_equal(grey_of(colour_message(colour, 0.0, "c")), grey)
    np.testing.assert_array_equal(grey_of(compressed(grey, "PNG")), grey)
    smooth = np.tile(np.linspace(0, 255, 32).astype(np.uint8), (24, 1))
    assert np.abs(grey_of(compressed(smooth, "JPEG")).astype(int) - smooth).max() < 8


@pytest.mark.parametrize("data", [b"", b"no image", b"\x89PNG\r\n\x1a\n" + b"x" * 40, b"GIF89a"])
def test_invalid_images_raise_input_errors(data: bytes) -> None:
    broken = compressed(picture(1), "PNG")
    broken.data = np.frombuffer(data, np.uint8)
    with pytest.raises(InputError, match="can not be read"):
        grey_of(broken)


def test_deep_images_are_refused() -> None:
    with pytest.raises(InputError, match="mode I;16"):
        grey_of(compressed(np.ones((4, 5), np.uint16), "PNG"))
