"""The file beside an ONNX network of another program: its classes, input and output."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from circumspect.classification.input_spec import InputSpec
from circumspect.classification.input_spec_dict import input_spec_from_dict
from circumspect.classification.model_description import (
    ModelDescription,
    checked_temperature,
)
from circumspect.errors import CircumspectError, InputError, WeightsError, printable, reason_of

SUFFIXES = (".input.toml", ".input.json")
"""Suffixes of the file beside NETWORK.onnx."""
MAX_BYTES = 1 << 20
AXES = {"cylindrical": "NCRAH", "rectangular": "NCXYZ", "points": "NPC"}
"""Kind of input to the axes in the order of the arrays here: N inputs, C channels or coordinates, R
radius, A azimuth, H height, P points."""
_TABLES = {
    "": ("classes", "other", "input", "output"),
    "output": ("name", "values", "temperature"),
}
Values = Literal["logits", "probabilities"]


@dataclass(frozen=True)
class InputSpecFile:
    """The content of an input specification file.

    Attributes:
        path: The file, for messages.
        classes: Class names in the order of the outputs.
        other: The class of other things, which is never a label; None without one.
        input_spec: How clouds become inputs.
        layout: The axes of the network's input: `AXES` in any order, of grids also without C.
        input_name: Of the network's input; None where it has one only.
        output_name: Of the network's output; None where it has one only.
        values: What the output is.
        temperature: Divides the logits.
        sha256: Of the file.
    """

    path: Path
    classes: tuple[str, ...]
    other: str | None
    input_spec: InputSpec
    layout: str
    input_name: str | None
    output_name: str | None
    values: Values
    temperature: float
    sha256: str

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> InputSpecFile:
        """Read a TOML or JSON file.

        Raises:
            InputError: Missing, broken, or an entry is missing, unknown or out of range.
        """
        file = Path(path)
        try:
            content = _read(file)
            return _checked(file, _parsed(file, content), hashlib.sha256(content).hexdigest())
        except CircumspectError as error:
            raise InputError(f"{file}: {error}") from error

    @classmethod
    def beside(cls, network: Path) -> InputSpecFile | None:
        """The specification beside an ONNX file; None where there is none.

        Raises:
            InputError: See `load`; or there are two.
        """
        found = [file for file in spec_paths(network) if file.exists()]
        if len(found) > 1:
            raise InputError(f"{found[0]}: {found[1].name} lies beside it; remove one of them")
        return cls.load(found[0]) if found else None

    def description(self, name: str) -> dict[str, Any]:
        """The same in the form that `circumspect export` writes into ONNX files."""
        described = {
            "name": name,
            "classes": list(self.classes),
            "grid": self.input_spec.to_dict(),
            "temperature": self.temperature,
            "input_spec_sha256": self.sha256,
        }
        return described if self.other is None else {**described, "other": self.other}


def spec_paths(network: Path) -> list[Path]:
    """Where the specification of an ONNX file may lie."""
    return [network.with_name(network.stem + suffix) for suffix in SUFFIXES]


def _read(file: Path) -> bytes:
    try:
        if not file.is_file():
            raise InputError("no such file")
        if file.stat().st_size > MAX_BYTES:
            raise InputError(f"larger than {MAX_BYTES >> 20} MiB; no input specification is")
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"can not be read ({reason_of(error)})") from error


def _parsed(file: Path, content: bytes) -> Mapping[str, Any]:
    kind = "JSON" if file.suffix.lower() == ".json" else "TOML"
    try:
        text = content.decode()
        document = json.loads(text) if kind == "JSON" else _parsed_toml(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not {kind} ({error})") from error
    if not isinstance(document, dict):
        raise InputError("an input specification is an object with classes and input")
    return document


def _parsed_toml(text: str) -> dict[str, Any]:
    # Few runs have such a file, and all would wait for the import.
    import tomllib

    return tomllib.loads(text)


def _checked(file: Path, document: Mapping[str, Any], sha256: str) -> InputSpecFile:
    _require_known("", document)
    for name in ("classes", "input"):
        if name not in document:
            raise InputError(f"'{name}' is missing; docs/own-network.md has an example")
    shown, given = _table(document, "input"), _table(document, "output")
    _require_known("output", given)
    settings = {key: shown[key] for key in shown if key not in ("name", "layout")}
    input_spec = _input_spec(settings)
    values = given.get("values", "logits")
    if values not in ("logits", "probabilities"):
        raise InputError(f"output.values must be logits or probabilities, not {values!r:.40}")
    if values == "probabilities" and "temperature" in given:
        raise InputError("output.temperature goes with logits; leave it out")
    # The same checks as of the description in a file of `circumspect export`.
    described = {key: document[key] for key in ("classes", "other") if key in document}
    try:
        ModelDescription.from_dict({**described, "grid": input_spec.to_dict()})
    except WeightsError as error:
        raise InputError(str(error).removeprefix("its ")) from error
    return InputSpecFile(
        file,
        tuple(document["classes"]),
        document.get("other"),
        input_spec,
        _layout(shown.get("layout"), input_spec),
        _name(shown, "input"),
        _name(given, "output"),
        values,
        checked_temperature(given.get("temperature", 1.0)),
        sha256,
    )


def _input_spec(settings: Mapping[str, Any]) -> InputSpec:
    try:
        if "kind" not in settings:
            raise InputError(f"'kind' is missing; one of {', '.join(AXES)}")
        input_spec = input_spec_from_dict(settings)
    except InputError as error:
        raise InputError(f"input: {error}") from error
    if input_spec.takes_context:
        raise InputError(
            "input: visibility and metric are for networks of circumspect; leave them out"
        )
    return input_spec


def _layout(given: Any, input_spec: InputSpec) -> str:
    axes = AXES[input_spec.kind]
    if given is None:
        return axes
    channels = {1} if input_spec.kind == "points" else {0, 1}
    letters = sorted(given) if isinstance(given, str) else []
    fits = [sorted(axes.replace("C", "C" * count)) for count in sorted(channels)]
    if letters not in fits:
        optional = "" if input_spec.kind == "points" else "; C may be left out"
        raise InputError(
            f"input.layout must hold each of {', '.join(axes)} once{optional}, not {given!r:.40}"
        )
    return str(given)


def _table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"'{name}' must be a table, not {table!r:.40}")
    return table


def _name(table: Mapping[str, Any], of: str) -> str | None:
    name = table.get("name")
    if name is not None and not isinstance(name, str):
        raise InputError(f"{of}.name must be text, not {name!r:.40}")
    return name


def _require_known(table: str, entries: Mapping[str, Any]) -> None:
    known = _TABLES[table]
    if unknown := sorted(set(entries) - set(known)):
        where = f"{table}." if table else ""
        raise InputError(
            f"unknown entry '{where}{printable(str(unknown[0])[:40])}'; known: {', '.join(known)}"
        )
