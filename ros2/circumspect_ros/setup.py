"""How colcon installs the package. Its version and license stand in package.xml."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import setup

NAME = "circumspect_ros"
HERE = Path(__file__).resolve().parent
SHARED = ("launch", "config", "rviz", "foxglove")
MANIFEST = ElementTree.parse(HERE / "package.xml").getroot()


def files_in(folder: str) -> list[str]:
    """Paths of a folder's files, relative to this package."""
    return sorted(f"{folder}/{path.name}" for path in (HERE / folder).iterdir() if path.is_file())


setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *((f"share/{NAME}/{folder}", files_in(folder)) for folder in SHARED),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer=MANIFEST.findtext("maintainer"),
    description="The circumspect node over rclpy.",
    license=MANIFEST.findtext("license"),
    entry_points={"console_scripts": [f"circumspect = {NAME}.node:main"]},
)
