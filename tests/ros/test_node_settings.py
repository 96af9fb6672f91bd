"""Parameters from flags and files, and invalid ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from circumspect.cli.main import main, parsed
from circumspect.errors import CircumspectError, InputError
from circumspect.ros.names import dds_topic, node_path, topic_path
from circumspect.ros.node_settings import NodeSettings, read_parameters

FILE = """
/**:
  ros__parameters:
    rate: 2.5
    use_sim_time: true
circumspect:
  ros__parameters:
    depth: /cam/depth/image_raw
    mount: [0.1, 0, 0.9, 0.0, 30]
    autostart: false
other_node:
  ros__parameters: {depht: 3}
robot1:
  circumspect:
    ros__parameters:
      queue: 7
"""
HUGE, HEX = "9" * 400, "0x" + "f" * 5000
"""The first exceeds a double, the second Python's limit for decimal text."""


@pytest.fixture
def params(tmp_path: Path) -> Path:
    path = tmp_path / "robot.yaml"
    path.write_text(FILE)
    return path


def test_a_parameter_file_of_ros(params: Path) -> None:
    node = NodeSettings.from_parameters(read_parameters(params, "/circumspect"))
    assert node.depth_topic == "/cam/depth/image_raw"
    assert node.info_topic == "/cam/depth/camera_info"
    assert node.mount == (0.1, 0.0, 0.9, 0.0, 30.0)
    assert (node.rate, node.queue, node.autostart) == (2.5, 4, False)


def test_nested_namespaces_add_to_the_wildcard(params: Path) -> None:
    read = read_parameters(params, "/robot1/circumspect")
    assert (read["queue"], read["rate"]) == (7, 2.5)


def test_flags_win_over_the_file_and_the_file_over_defaults(params: Path) -> None:
    node = parsed("ros2", ["--params-file", str(params), "--rate", "1", "--autostart"]).node
    assert (node.rate, node.autostart, node.depth) == (1.0, True, "/cam/depth/image_raw")
    assert parsed("ros2", ["--params-file", str(params)]).node.rate == 2.5
    named = parsed("ros2", ["--params-file", str(params), "--namespace", "robot1"]).node
    assert (named.node, named.queue) == ("/robot1/circumspect", 7)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("circumspect: {ros__parameters: {depht: x}}", "no parameter 'depht'; did you mean depth?"),
        ("circumspect: {ros__parameters: {zzz: x}}", "no parameter 'zzz'; known: name"),
        ("circumspect: {ros__parameters: {rate: fast}}", "rate is a number, not 'fast'"),
        ("circumspect: {ros__parameters: {rate: .nan}}", "rate is a number"),
        ("circumspect: {ros__parameters: {rate: true}}", "rate is a number"),
        ("circumspect: {ros__parameters: {queue: 2.5}}", "queue is a whole number"),
        ("circumspect: {ros__parameters: {autostart: 1}}", "autostart is true or false"),
        ("circumspect: {ros__parameters: {depth: [1]}}", "depth is a text"),
        ("circumspect: {ros__parameters: {mount: [1, 2]}}", "mount takes 5 numbers"),
        ("circumspect: {ros__parameters: {depth_range: [3]}}", "depth_range takes 2 numbers"),
        ("circumspect: {ros__parameters: {depth_range: [3, 1]}}", "the maximum [m], not 3 and 1"),
        ("circumspect: {ros__parameters: {mount: [1, x, 1, 1, 1]}}", "mount is a list of numbers"),
        (
            "circumspect: {ros__parameters: {driver: kinect}}",
            "no driver 'kinect'; known: realsense",
        ),
        ("circumspect: {ros__parameters: {poses: maybe}}", "poses must be found or given"),
        ("circumspect: {ros__parameters: {depth: 'a b'}}", "is not a valid ROS name"),
        ("circumspect: {ros__parameters: {queue: 0}}", "the queue holds 1 to 100"),
        ("circumspect: {ros__parameters: {frame: ''}}", "need names"),
        ("circumspect: {ros__parameters: 3}", "must contain names and values"),
        ("camera: {ros__parameters: {}}", "contains no ros__parameters of the node /circumspect"),
        ("- 1", "is not a parameter file"),
        ("", "is not a parameter file"),
        ("a: [1", "is not YAML at line 1"),
        ("a: &x [1]\nb: [*x, *x]", "has aliases"),
        ("a: " + 200_000 * "[", "is nested deeper than 20 levels"),
        ("a: !!python/object/apply:os.system ['true']", "is not YAML"),
        ("#" * 300_000, "more than 262144 bytes"),
    ],
)
def test_invalid_parameter_files_are_refused(tmp_path: Path, capsys, text: str, said: str) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(text)
    assert main(["ros2", "--params-file", str(path)]) == 2
    output = capsys.readouterr().err
    assert said in output
    assert output.count("\n") == 1


@pytest.mark.parametrize("number", [HUGE, HEX], ids=["huge", "hex"])
@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("rate: NUMBER", "the parameter rate is a number, not one of more than 18 digits"),
        ("queue: NUMBER", "the parameter queue is a whole number, not one of more"),
        ("mount: [NUMBER, 0, 0, 0, 0]", "the parameter mount is a list of numbers, not"),
        ("depth: NUMBER", "the parameter depth is a text, not one of more"),
        ("autostart: NUMBER", "the parameter autostart is true or false, not one of more"),
    ],
)
def test_numbers_outside_the_range_of_ros_are_refused(
    tmp_path: Path, capsys, entry: str, said: str, number: str
) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(f"circumspect: {{ros__parameters: {{{entry.replace('NUMBER', number)}}}}}")
    assert main(["ros2", "--params-file", str(path)]) == 2
    output = capsys.readouterr().err
    assert said in output
    assert output.count("\n") == 1
    assert len(output) < 200


@pytest.mark.parametrize("side", [float("nan"), float("inf"), 640.7, 1e9, -3.0, 0.0])
def test_a_fractional_image_size_is_refused(side: float) -> None:
    with pytest.raises(InputError, match="whole pixels"):
        NodeSettings(size=(640.0, side))


@pytest.mark.parametrize("wrong", [(3.0, 2.0), (1.0, 1.0), (-1.0, 2.0), (float("nan"), 2.0)])
def test_an_invalid_depth_range_is_refused(wrong: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="minimum and the maximum"):
        _ = NodeSettings(depth_range=wrong).noise
    assert NodeSettings(depth_range=(0.3, 6.0)).noise.depth_range == (0.3, 6.0)


def test_a_missing_parameter_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="can not be read"):
        read_parameters(tmp_path / "none.yaml", "/circumspect")


def test_node_topic_and_dds_names() -> None:
    assert node_path("", "circumspect") == "/circumspect"
    assert node_path("/robot1/", "seer") == "/robot1/seer"
    assert topic_path("/odom", "/a/b") == "/odom"
    assert topic_path("odom", "/a/b") == "/a/odom"
    assert topic_path("~/model", "/a/b") == "/a/b/model"
    assert dds_topic("/odom") == "rt/odom"


@pytest.mark.parametrize("name", ["", "/", "a//b", "/1a", "a b", "/a/", "/ä", "x" * 300, "../x"])
def test_invalid_ros_names_are_refused(name: str) -> None:
    with pytest.raises(CircumspectError, match="is not a valid ROS name"):
        topic_path(name, "/node")


def test_a_driver_has_its_topics() -> None:
    assert NodeSettings().depth_topic == "/camera/camera/depth/image_rect_raw"
    assert NodeSettings(driver="orbbec").info_topic == "/camera/depth/camera_info"
    assert NodeSettings(intrinsics=(500, 500, 320, 240)).info_topic is None
