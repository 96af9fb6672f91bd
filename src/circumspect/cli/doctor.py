"""`circumspect doctor`: what is installed, which extras are missing, how to get them."""

from __future__ import annotations

import json
import platform
from dataclasses import dataclass
from importlib import metadata

EXTRAS = {
    "runtime": (
        "numpy",
        "scipy",
        "trimesh",
        "small_gicp",
        "onnxruntime",
        "tyro",
        "rich",
        "pillow",
    ),
    "sim": ("embreex", "mujoco-core", "matplotlib"),
    "train": ("torch", "accelerate", "safetensors", "onnx", "onnxscript", "tensorboard"),
    "data": ("pooch",),
    "bags": ("mcap", "rosbags"),
    "viewer": ("viser",),
    "ros2": ("cyclonedds", "rosbags", "PyYAML"),
    "locate": ("pupil-apriltags", "opencv-python-headless"),
}


@dataclass(frozen=True)
class Doctor:
    """What is installed, which extras are missing, how to get them."""

    json: bool = False
    """Print one JSON object and nothing else on standard output."""

    def run(self) -> int:
        """Report; exit code 1 where the runtime itself is incomplete."""
        found = {extra: {name: _version(name) for name in names} for extra, names in EXTRAS.items()}
        if self.json:
            print(json.dumps({"python": platform.python_version(), **found}))  # noqa: T201
        else:
            _show(found)
        return 0 if all(found["runtime"].values()) else 1


def _show(found: dict[str, dict[str, str | None]]) -> None:
    from rich.console import Console

    console = Console()
    console.print(f"circumspect {metadata.version('circumspect')}, {platform.platform()}")
    for extra, packages in found.items():
        missing = [name for name, version in packages.items() if version is None]
        state = "complete" if not missing else f"missing {', '.join(missing)}"
        console.print(f"[bold]{extra}[/bold]: {state}")
        for name, version in packages.items():
            console.print(f"  {name:14} {version or '-'}")
        if missing:
            target = "circumspect" if extra == "runtime" else f'"circumspect\\[{extra}]"'
            console.print(f"  get it with: pip install {target}")


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
