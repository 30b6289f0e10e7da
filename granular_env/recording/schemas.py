"""Protobuf messages: the block that holds a log's exact content, and three for stock viewers. No protoc is needed.

The descriptors are built at run time. Points, spheres and named numbers are laid out by numpy as whole arrays of bytes:
building them as protobuf objects would take longer than the run that they show.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from .format import varint

_DOUBLE, _BOOL, _ENUM, _BYTES, _STRING, _MESSAGE, _FIXED32 = 1, 8, 14, 12, 9, 11, 7
_ONE, _MANY = 1, 3
_UINT32, _FLOAT32, _UINT8 = 5, 7, 1
FRAME = "world"
Parts = list[bytes | memoryview]

_VECTOR, _POSE, _COLOR, _STAMP = ".foxglove.Vector3", ".foxglove.Pose", ".foxglove.Color", ".google.protobuf.Timestamp"
_COMMON = {
    "Vector3": [(axis, _DOUBLE, _ONE, None) for axis in "xyz"],
    "Quaternion": [(axis, _DOUBLE, _ONE, None) for axis in "xyzw"],
    "Pose": [("position", _MESSAGE, _ONE, _VECTOR), ("orientation", _MESSAGE, _ONE, ".foxglove.Quaternion")],
}
_POINT_CLOUD = {
    **_COMMON,
    "PackedElementField": [
        ("name", _STRING, _ONE, None),
        ("offset", _FIXED32, _ONE, None),
        ("type", _ENUM, _ONE, ".foxglove.PackedElementField.NumericType"),
    ],
    "PointCloud": [
        ("timestamp", _MESSAGE, _ONE, _STAMP),
        ("frame_id", _STRING, _ONE, None),
        ("pose", _MESSAGE, _ONE, _POSE),
        ("point_stride", _FIXED32, _ONE, None),
        ("fields", _MESSAGE, _MANY, ".foxglove.PackedElementField"),
        ("data", _BYTES, _ONE, None),
    ],
}
# Of the official message only what is written; the numbers of the fields are the official ones.
_SCENE_UPDATE = {
    **_COMMON,
    "Color": [(channel, _DOUBLE, _ONE, None) for channel in "rgba"],
    "SpherePrimitive": [("pose", _MESSAGE, _ONE, _POSE), ("size", _MESSAGE, _ONE, _VECTOR), ("color", _MESSAGE, _ONE, _COLOR)],
    "SceneEntity": [
        ("timestamp", _MESSAGE, _ONE, _STAMP),
        ("frame_id", _STRING, _ONE, None),
        ("id", _STRING, _ONE, None),
        ("spheres", _MESSAGE, _MANY, ".foxglove.SpherePrimitive", 9),
    ],
    "SceneUpdate": [("entities", _MESSAGE, _MANY, ".foxglove.SceneEntity", 2)],
}


@cache
def block_schema() -> bytes:
    """Return the FileDescriptorSet of ``granular.Block``: one field of bytes."""
    return _file_set("granular", "Block", {"Block": [("data", _BYTES, _ONE, None)]}, stamped=False)


@cache
def point_cloud_schema() -> bytes:
    """Return the FileDescriptorSet of ``foxglove.PointCloud``."""
    return _file_set("foxglove", "PointCloud", _POINT_CLOUD)


@cache
def scene_update_schema() -> bytes:
    """Return the FileDescriptorSet of ``foxglove.SceneUpdate``, as far as spheres need it."""
    return _file_set("foxglove", "SceneUpdate", _SCENE_UPDATE)


def scalars_schema(names: Sequence[str]) -> bytes:
    """Return the FileDescriptorSet of ``granular.Scalars``: one double for each name."""
    fields = [(name, _DOUBLE, _ONE, None) for name in names]
    return _file_set("granular", "Scalars", {"Scalars": fields}, stamped=False)


def _file_set(package: str, name: str, messages: dict[str, Any], stamped: bool = True) -> bytes:
    from google.protobuf import descriptor_pb2, timestamp_pb2

    stamp = descriptor_pb2.FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(stamp)
    file = descriptor_pb2.FileDescriptorProto(name=f"{package}/{name}.proto", package=package, syntax="proto3")
    for message_name, fields in messages.items():
        message = file.message_type.add(name=message_name)
        for place, (field, kind, label, type_name, *number) in enumerate(fields, 1):
            number = number[0] if number else place
            message.field.add(name=field, number=number, type=kind, label=label, type_name=type_name)  # type: ignore[arg-type]
        if message_name == "PackedElementField":
            kinds = message.enum_type.add(name="NumericType")
            for value, kind in enumerate(_NUMERIC_TYPES):
                kinds.value.add(name=kind, number=value)
    if stamped:
        file.dependency.append(stamp.name)
    files = [stamp, file] if stamped else [file]
    return descriptor_pb2.FileDescriptorSet(file=files).SerializeToString(deterministic=True)


_NUMERIC_TYPES = ("UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64")
_POINT = np.dtype([("position", "<f4", 3), ("colour", "u1", 4)])


def encode_point_cloud(nanoseconds: int, positions: np.ndarray, colours: np.ndarray) -> Parts:
    """Return one ``foxglove.PointCloud``, in parts.

    The bytes of a colour are blue, green, red, alpha. Rerun reads them as four fields of these names; Foxglove chooses by
    itself the field ``rgba``, which is the same four bytes as one number.

    Args:
        nanoseconds: the time stamp.
        positions: shape (n, 3) [m].
        colours: red, green, blue, alpha; shape (n, 4), uint8.
    """
    points = np.empty(len(positions), dtype=_POINT)
    points["position"], points["colour"] = positions, colours[:, [2, 1, 0, 3]]
    # The points are the last field: protobuf would copy them twice.
    data = points.view(np.uint8).data
    return [_field(1, _stamp(nanoseconds)) + _point_cloud_head() + b"\x32" + varint(len(data)), data]


@cache
def _point_cloud_head() -> bytes:
    """Return frame, pose, stride and fields. Viewers draw nothing where the pose is not set."""
    fields = [(axis, 4 * place, _FLOAT32) for place, axis in enumerate("xyz")]
    fields += [(name, 12 + place, _UINT8) for place, name in enumerate(("blue", "green", "red", "alpha"))]
    fields += [("rgba", 12, _UINT32)]
    described = [
        _field(1, name.encode()) + (b"\x15" + offset.to_bytes(4, "little") if offset else b"") + b"\x18" + varint(kind)
        for name, offset, kind in fields
    ]
    pose = _field(1, b"") + _field(2, b"\x21" + np.float64(1.0).tobytes())
    stride = b"\x25" + _POINT.itemsize.to_bytes(4, "little")
    return _field(2, FRAME.encode()) + _field(3, pose) + stride + b"".join(_field(5, part) for part in described)


# Steps of a colour's channel: numbers of few digits compress well.
_TINTS = 64.0
_SPHERE = np.dtype(
    [
        ("head", "V2"), ("pose", "V4"), ("x_tag", "V1"), ("x", "<f8"), ("y_tag", "V1"), ("y", "<f8"), ("z_tag", "V1"),
        ("z", "<f8"), ("turn", "V11"), ("size", "V29"), ("colour", "V2"), ("r_tag", "V1"), ("r", "<f8"), ("g_tag", "V1"),
        ("g", "<f8"), ("b_tag", "V1"), ("b", "<f8"), ("alpha", "V9"),
    ]
)  # fmt: skip


def encode_spheres(nanoseconds: int, positions: np.ndarray, radius: np.ndarray, colours: np.ndarray) -> Parts:
    """Return one ``foxglove.SceneUpdate`` with one entity: a sphere of its size for each position.

    Args:
        nanoseconds: the time stamp.
        positions: shape (n, 3) [m].
        radius: shape (n,) [m].
        colours: red, green, blue, alpha; shape (n, 4), uint8; alpha is not used.
    """
    spheres = np.empty(len(positions), dtype=_SPHERE)
    one = np.float64(1.0).tobytes()
    spheres["head"] = bytes([0x4A, _SPHERE.itemsize - 2])
    spheres["pose"] = bytes([0x0A, 40, 0x0A, 27])
    spheres["turn"] = bytes([0x12, 9, 0x21]) + one
    spheres["colour"] = bytes([0x1A, 36])
    spheres["alpha"] = b"\x21" + one
    for place, axis in enumerate("xyz"):
        spheres[f"{axis}_tag"], spheres[axis] = bytes([9 + 8 * place]), positions[:, place]
    for place, channel in enumerate("rgb"):
        spheres[f"{channel}_tag"], spheres[channel] = (
            bytes([9 + 8 * place]),
            np.rint(colours[:, place] * (_TINTS / 255.0)) / _TINTS,
        )
    spheres["size"] = _sizes(radius)
    entity = _field(1, _stamp(nanoseconds)) + _field(2, FRAME.encode()) + _field(3, b"grains")
    data = spheres.view(np.uint8).data
    return [b"\x12" + varint(len(entity) + len(data)) + entity, data]


def _sizes(radius: np.ndarray) -> np.ndarray:
    tagged = [(f"{axis}{part}", kind) for axis in "xyz" for part, kind in (("_tag", "V1"), ("_value", "<f8"))]
    sizes = np.empty(len(radius), dtype=[("head", "V2"), *tagged])
    sizes["head"] = bytes([0x12, 27])
    for place, axis in enumerate("xyz"):
        sizes[f"{axis}_tag"], sizes[f"{axis}_value"] = bytes([9 + 8 * place]), 2.0 * radius
    return sizes.view("V29")


def encode_scalars(rows: np.ndarray) -> list[bytes]:
    """Return one ``granular.Scalars`` for each row of `rows`, shape (messages, names)."""
    tags = [varint((place << 3) | 1) for place in range(1, 1 + rows.shape[1])]
    layout = [pair for place, tag in enumerate(tags) for pair in ((f"t{place}", f"V{len(tag)}"), (f"v{place}", "<f8"))]
    body = np.empty(len(rows), dtype=layout)
    for place, tag in enumerate(tags):
        body[f"t{place}"], body[f"v{place}"] = tag, rows[:, place]
    return [row.tobytes() for row in body]


def _stamp(nanoseconds: int) -> bytes:
    seconds, rest = divmod(nanoseconds, 10**9)
    return (b"\x08" + varint(seconds) if seconds else b"") + (b"\x10" + varint(rest) if rest else b"")


def _field(number: int, content: bytes) -> bytes:
    """Return a field of bytes, text or a message."""
    return varint((number << 3) | 2) + varint(len(content)) + content
