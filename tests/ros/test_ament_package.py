"""The ament package's launch file, RViz configuration, Foxglove layout and manifest."""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest
from orbiting_robot import MemoryBus

from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RESET, START, STOP
from circumspect.ros.result_publisher import ResultPublisher

yaml = pytest.importorskip("yaml", reason='needs pip install "circumspect[ros2]"')

PACKAGE = Path(__file__).resolve().parents[2] / "ros2" / "circumspect_ros"


@pytest.fixture(scope="module")
def published() -> dict[str, Any]:
    """Topics that the node publishes with default settings, with type and quality."""
    bus = MemoryBus()
    ResultPublisher(bus, NodeSettings())
    return bus.offered


def displays() -> list[dict[str, Any]]:
    text = (PACKAGE / "rviz" / "circumspect.rviz").read_text(encoding="utf-8")
    return yaml.safe_load(text)["Visualization Manager"]["Displays"]


def layout() -> dict[str, Any]:
    text = (PACKAGE / "foxglove" / "circumspect.json").read_text(encoding="utf-8")
    return json.loads(text)


def test_rviz_displays_what_the_node_publishes(published: dict[str, Any]) -> None:
    shown = {one["Topic"]["Value"]: one for one in displays() if "Topic" in one}
    own = {topic for topic in published if topic.startswith("/circumspect/")}
    assert own == {topic for topic in shown if topic.startswith("/circumspect/")}
    assert set(shown) - own == {NodeSettings().depth_topic}
    for topic in own:
        kind, quality = published[topic]
        display, plugin = shown[topic], shown[topic]["Class"].rsplit("/", 1)[1]
        assert plugin in (kind.rsplit("/", 1)[1], kind.rsplit("/", 1)[1].removesuffix("Stamped"))
        assert quality.latched == (display["Topic"]["Durability Policy"] == "Transient Local")
        assert quality.depth == display["Topic"]["Depth"]


def test_rviz_and_foxglove_use_the_frame_of_the_node() -> None:
    text = (PACKAGE / "rviz" / "circumspect.rviz").read_text(encoding="utf-8")
    options = yaml.safe_load(text)["Visualization Manager"]["Global Options"]
    scene = layout()["configById"]["3D!scene"]
    assert options["Fixed Frame"] == scene["followTf"] == NodeSettings().output_frame


def test_foxglove_shows_what_the_node_publishes(published: dict[str, Any]) -> None:
    panels, settings = layout()["configById"], NodeSettings()
    own = {topic for topic in published if topic.startswith("/circumspect/")}
    shown = set(panels["3D!scene"]["topics"])
    shown.add(panels["RawMessages!detections"]["topicPath"].split(".")[0])
    assert shown == own
    assert panels["DiagnosticStatusPanel!node"]["topicToRender"] in published
    image = panels["Image!depth"]["imageMode"]
    assert image["imageTopic"] == settings.depth_topic
    assert image["calibrationTopic"] == settings.info_topic


def test_foxglove_sends_the_node_s_commands() -> None:
    panels = layout()["configById"]
    sent = {panel["topicName"] for name, panel in panels.items() if name.startswith("Publish!")}
    assert sent == {f"/circumspect/{command}" for command in (START, STOP, RESET)}


def test_each_panel_of_the_layout_is_described() -> None:
    def names(part: Any) -> list[str]:
        if isinstance(part, str):
            return [part]
        return [*names(part["first"]), *names(part["second"])]

    assert sorted(names(layout()["layout"])) == sorted(layout()["configById"])


@pytest.fixture
def launch_file(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The launch file's names, over a stub of the part of launch that it uses."""

    def stub(name: str, **held: Any) -> None:
        module = ModuleType(name)
        module.__dict__.update(held)
        monkeypatch.setitem(sys.modules, name, module)

    class Configuration:
        def __init__(self, name: str) -> None:
            self._name = name

        def perform(self, context: dict[str, str]) -> str:
            return context[self._name]

    def record(*words: Any, **keywords: Any) -> SimpleNamespace:
        return SimpleNamespace(words=words, **keywords)

    stub("ament_index_python")
    stub("ament_index_python.packages", get_package_share_directory=lambda name: str(PACKAGE))
    stub("launch", LaunchContext=dict, LaunchDescription=record)
    stub("launch.actions", DeclareLaunchArgument=record, OpaqueFunction=record)
    stub("launch.substitutions", LaunchConfiguration=Configuration)
    stub("launch_ros")
    stub("launch_ros.actions", Node=record)
    return runpy.run_path(str(PACKAGE / "launch" / "circumspect.launch.py"))


def arguments(launch_file: dict[str, Any], **given: str) -> dict[str, str]:
    """All arguments with their defaults, and those that are given."""
    described = launch_file["generate_launch_description"]().words[0]
    usual = {one.words[0]: one.default_value for one in described if one.words}
    assert set(given) <= set(usual)
    return {**usual, **given}


def test_arguments_of_the_launch_file_are_parameters_of_the_node(
    launch_file: dict[str, Any],
) -> None:
    words = {"driver": "orbbec", "rate": "10", "autostart": "false"}
    (node,) = launch_file["nodes"](arguments(launch_file, **words))
    file, given = node.parameters
    assert given == {"driver": "orbbec", "rate": 10.0, "autostart": False}
    assert NodeSettings.from_parameters(given).driver == "orbbec"
    assert Path(file).is_file()
    defaults = NodeSettings()
    for name, (kind, _) in launch_file["PARAMETERS"].items():
        assert type(getattr(defaults, name)) is kind


def test_without_arguments_the_parameter_file_holds(launch_file: dict[str, Any]) -> None:
    (node,) = launch_file["nodes"](arguments(launch_file))
    assert node.parameters[1] == {}
    assert (node.name, node.namespace) == ("circumspect", "")


def test_rviz_follows_the_node_s_name(launch_file: dict[str, Any]) -> None:
    words = {"rviz": "true", "namespace": "/robot1/", "name": "seer"}
    node, rviz = launch_file["nodes"](arguments(launch_file, **words))
    assert node.namespace == "/robot1/"
    assert Path(rviz.arguments[1]).is_file()
    assert ("/circumspect/model", "/robot1/seer/model") in rviz.remappings
    shown = {one["Topic"]["Value"] for one in displays() if "Topic" in one}
    assert {topic for topic, _ in rviz.remappings} <= shown


def test_the_manifest_names_what_is_imported() -> None:
    root = ElementTree.parse(PACKAGE / "package.xml").getroot()
    assert root.findtext("license") == "Apache-2.0"
    assert root.findtext("maintainer")
    named = {one.text for kind in ("depend", "exec_depend") for one in root.iter(kind)}
    sources = [*PACKAGE.glob("circumspect_ros/*.py"), *PACKAGE.glob("launch/*.py")]
    lines = "\n".join(path.read_text(encoding="utf-8") for path in sources).splitlines()
    words = [line.split() for line in lines if line.lstrip().startswith(("from ", "import "))]
    imported = {line[1].split(".")[0] for line in words}
    ours = {"circumspect", "circumspect_ros", "__future__"}
    assert imported - ours - set(sys.stdlib_module_names) <= named


def test_everything_shared_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    said: dict[str, Any] = {}
    setuptools = ModuleType("setuptools")
    setuptools.__dict__["setup"] = said.update
    monkeypatch.setitem(sys.modules, "setuptools", setuptools)
    runpy.run_path(str(PACKAGE / "setup.py"))
    installed = {path for _, paths in said["data_files"] for path in paths}
    for folder in ("launch", "config", "rviz", "foxglove"):
        files = {f"{folder}/{path.name}" for path in (PACKAGE / folder).glob("*.*")}
        assert files <= installed
