"""Schemas of the messages, and how the two for stock viewers are encoded.

The protobuf descriptors are built at run time (no protoc); the ROS 2 message is laid out by hand, it is a handful of fields.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from .format import varint

_DOUBLE, _ENUM, _BYTES, _STRING, _MESSAGE, _FIXED32 = 1, 14, 12, 9, 11, 7
_ONE, _MANY = 1, 3
_FLOAT32, _UINT8 = 7, 1

JOINT_STATE_NAME = "sensor_msgs/msg/JointState"
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


@cache
def block_schema() -> bytes:
    """FileDescriptorSet of ``granular.Block``: one field of bytes."""
    from google.protobuf import descriptor_pb2

    file = descriptor_pb2.FileDescriptorProto(name="granular/Block.proto", package="granular", syntax="proto3")
    file.message_type.add(name="Block").field.add(name="data", number=1, type=_BYTES, label=_ONE)  # type: ignore[arg-type]
    return descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)


@cache
def point_cloud_schema() -> bytes:
    """FileDescriptorSet of ``foxglove.PointCloud``."""
    from google.protobuf import descriptor_pb2, timestamp_pb2

    stamp = descriptor_pb2.FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(stamp)
    file = descriptor_pb2.FileDescriptorProto(name="foxglove/PointCloud.proto", package="foxglove", syntax="proto3")
    file.dependency.append(stamp.name)
    for name, fields in _MESSAGES.items():
        message = file.message_type.add(name=name)
        for number, (field, kind, label, type_name) in enumerate(fields, 1):
            message.field.add(name=field, number=number, type=kind, label=label, type_name=type_name)  # type: ignore[arg-type]
    kinds = next(m for m in file.message_type if m.name == "PackedElementField").enum_type.add(name="NumericType")
    for number, name in enumerate(("UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64")):
        kinds.value.add(name=name, number=number)
    return descriptor_pb2.FileDescriptorSet(file=[stamp, file]).SerializeToString(deterministic=True)


_MESSAGES = {
    "Vector3": [(axis, _DOUBLE, _ONE, None) for axis in "xyz"],
    "Quaternion": [(axis, _DOUBLE, _ONE, None) for axis in "xyzw"],
    "Pose": [("position", _MESSAGE, _ONE, ".foxglove.Vector3"), ("orientation", _MESSAGE, _ONE, ".foxglove.Quaternion")],
    "PackedElementField": [
        ("name", _STRING, _ONE, None),
        ("offset", _FIXED32, _ONE, None),
        ("type", _ENUM, _ONE, ".foxglove.PackedElementField.NumericType"),
    ],
    "PointCloud": [
        ("timestamp", _MESSAGE, _ONE, ".google.protobuf.Timestamp"),
        ("frame_id", _STRING, _ONE, None),
        ("pose", _MESSAGE, _ONE, ".foxglove.Pose"),
        ("point_stride", _FIXED32, _ONE, None),
        ("fields", _MESSAGE, _MANY, ".foxglove.PackedElementField"),
        ("data", _BYTES, _ONE, None),
    ],
}


@cache
def _point_cloud_class() -> Any:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(point_cloud_schema()).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("foxglove.PointCloud"))


def point_cloud(nanoseconds: int, positions: np.ndarray, colours: np.ndarray) -> list[bytes | memoryview]:
    """One ``foxglove.PointCloud``, in parts: positions (n, 3) [m] and colours (n, 4) uint8 RGBA, in the world's frame."""
    points = np.empty(len(positions), dtype=[("position", "<f4", 3), ("colour", "u1", 4)])
    points["position"], points["colour"] = positions, colours
    message = _point_cloud_class()(frame_id="world", point_stride=points.itemsize)
    message.timestamp.seconds, message.timestamp.nanos = divmod(nanoseconds, 10**9)
    # Viewers draw nothing where the pose is not set.
    message.pose.position.x = 0.0
    message.pose.orientation.w = 1.0
    for index, axis in enumerate("xyz"):
        message.fields.add(name=axis, offset=4 * index, type=_FLOAT32)
    for index, name in enumerate(("red", "green", "blue", "alpha")):
        message.fields.add(name=name, offset=12 + index, type=_UINT8)
    # The points are the last field; they are appended by hand, because protobuf would copy them twice.
    data = points.view(np.uint8).data
    return [message.SerializeToString(deterministic=True) + b"\x32" + varint(len(data)), data]


def joint_state(nanoseconds: int, names: Sequence[str], values: Sequence[float]) -> list[bytes | memoryview]:
    """One ROS 2 ``sensor_msgs/JointState`` in CDR, little-endian: each scalar as the position of a joint of its name."""
    seconds, rest = divmod(nanoseconds, 10**9)
    body = bytearray(struct.pack("<iI", min(seconds, 2**31 - 1), rest))
    _add_string(body, "")
    _add_count(body, len(names))
    for name in names:
        _add_string(body, name)
    _add_count(body, len(values))
    if values:
        body += bytes(-len(body) % 8)
        body += struct.pack(f"<{len(values)}d", *values)
    _add_count(body, 0)
    _add_count(body, 0)
    return [b"\x00\x01\x00\x00" + bytes(body)]


def _add_count(body: bytearray, count: int) -> None:
    body += bytes(-len(body) % 4)
    body += struct.pack("<I", count)


def _add_string(body: bytearray, text: str) -> None:
    data = text.encode() + b"\x00"
    _add_count(body, len(data))
    body += data
