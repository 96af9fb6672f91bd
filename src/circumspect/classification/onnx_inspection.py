"""Check an untrusted ONNX file before ONNX Runtime loads it.

A network is a list of plain arithmetic with its weights inside. Everything else is refused: weights
in other files, loops and branches, operators of other libraries. The file's encoding (protocol
buffers) is decoded here, since the package onnx is not on the robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from circumspect.errors import WeightsError

MAX_FILE_BYTES = 512 << 20
"""Largest size of a file [bytes]."""
MAX_NODES = 20_000
MAX_MEMORY_BYTES = 2 << 30
"""Memory of all untrusted networks together while they run [bytes]."""
PLAIN_DOMAINS = (b"", b"ai.onnx")

# Field numbers of onnx.proto3 (github.com/onnx/onnx, ONNX IR version 3 to 13).
_MODEL_GRAPH, _MODEL_TRAINING, _MODEL_FUNCTIONS = 7, 20, 25
_GRAPH_NODE, _GRAPH_INITIALIZER, _GRAPH_SPARSE = 1, 5, 15
_NODE_TYPE, _NODE_ATTRIBUTE, _NODE_DOMAIN = 4, 5, 7
_ATTRIBUTE_TENSOR, _ATTRIBUTE_GRAPH, _ATTRIBUTE_TENSORS, _ATTRIBUTE_GRAPHS = 5, 6, 10, 11
_ATTRIBUTE_SPARSE = (22, 23)
_TENSOR_EXTERNAL, _TENSOR_LOCATION = 13, 14


def require_plain_network(content: bytes) -> None:
    """Check a file as a whole.

    Raises:
        WeightsError: It is broken or contains more than arithmetic on its own weights.
    """
    if len(content) > MAX_FILE_BYTES:
        raise WeightsError(f"larger than {MAX_FILE_BYTES >> 20} MiB; no network here is")
    whole = memoryview(content)
    graphs = 0
    for number, value in _fields(whole):
        if number in (_MODEL_FUNCTIONS, _MODEL_TRAINING):
            raise WeightsError("it brings functions or training along; only networks are run")
        if number == _MODEL_GRAPH:
            graphs += 1
            _require_plain_graph(_message(value))
    if graphs != 1:
        raise WeightsError(f"it holds {graphs} networks")


def _require_plain_graph(graph: memoryview) -> None:
    nodes = 0
    for number, value in _fields(graph):
        if number == _GRAPH_NODE:
            nodes += 1
            _require_plain_node(_message(value))
        elif number == _GRAPH_INITIALIZER:
            _require_own_data(_message(value))
        elif number == _GRAPH_SPARSE:
            raise WeightsError("it has sparse weights, which unpack to any size")
    if nodes > MAX_NODES:
        raise WeightsError(f"it has {nodes} operators; no network here has")


def _require_plain_node(node: memoryview) -> None:
    kind = b"?"
    for number, value in _fields(node):
        if number == _NODE_TYPE:
            kind = bytes(_message(value))
        elif number == _NODE_DOMAIN and bytes(_message(value)) not in PLAIN_DOMAINS:
            raise WeightsError(f"its operator {_shown(kind)} is of another library")
        elif number == _NODE_ATTRIBUTE:
            _require_plain_attribute(_message(value), kind)


def _require_plain_attribute(attribute: memoryview, kind: bytes) -> None:
    for number, value in _fields(attribute):
        if number in (_ATTRIBUTE_GRAPH, _ATTRIBUTE_GRAPHS):
            raise WeightsError(f"its operator {_shown(kind)} loops or branches; none may")
        if number in _ATTRIBUTE_SPARSE:
            raise WeightsError("it has sparse weights, which unpack to any size")
        if number in (_ATTRIBUTE_TENSOR, _ATTRIBUTE_TENSORS):
            _require_own_data(_message(value))


def _require_own_data(tensor: memoryview) -> None:
    for number, value in _fields(tensor):
        if number == _TENSOR_EXTERNAL or (number == _TENSOR_LOCATION and value != 0):
            raise WeightsError("its weights lie in another file; they must be inside")


def _shown(name: bytes) -> str:
    return ascii(name.decode("latin-1")[:40])


def _message(value: int | memoryview) -> memoryview:
    if isinstance(value, int):
        raise WeightsError("it is broken: a number where a part should be")
    return value


def _fields(part: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """(number, value) of each field; fixed-size ones, which are not of interest, as 0."""
    place = 0
    while place < len(part):
        key, place = _number(part, place)
        number, wire = key >> 3, key & 7
        if wire == 0:
            value, place = _number(part, place)
            yield number, value
        elif wire == 2:
            size, place = _number(part, place)
            if size > len(part) - place:
                raise WeightsError("it is broken: a part is longer than the whole")
            yield number, part[place : place + size]
            place += size
        elif wire in (1, 5):
            place += 8 if wire == 1 else 4
            yield number, 0
        else:
            raise WeightsError("it is broken: an unknown kind of field")


def _number(part: memoryview, place: int) -> tuple[int, int]:
    """A number of varying length, and where it ends."""
    value = shift = 0
    while shift < 70 and place < len(part):
        byte = part[place]
        place += 1
        value |= (byte & 127) << shift
        if byte < 128:
            return value, place
        shift += 7
    raise WeightsError("it is broken: a number without an end")


@cache
def bound_memory() -> None:
    """Make an arena of bounded size for untrusted networks; select it with
    `session.use_env_allocators`. The shipped networks do not use it.
    """
    import onnxruntime

    memory = onnxruntime.OrtMemoryInfo(
        "Cpu", onnxruntime.OrtAllocatorType.ORT_ARENA_ALLOCATOR, 0, onnxruntime.OrtMemType.DEFAULT
    )
    arena = onnxruntime.OrtArenaCfg(
        {
            "max_mem": MAX_MEMORY_BYTES,
            "arena_extend_strategy": 1,  # As much as is asked for, not the next power of two.
            "initial_chunk_size_bytes": -1,
            "max_dead_bytes_per_chunk": -1,
        }
    )
    onnxruntime.create_and_register_allocator(memory, arena)
