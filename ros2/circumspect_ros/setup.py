"""How colcon installs the package."""

from setuptools import setup

NAME = "circumspect_ros"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/circumspect.launch.py"]),
        (f"share/{NAME}/config", ["config/circumspect.yaml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    description="The circumspect node over rclpy.",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"circumspect = {NAME}.node:main"]},
)
