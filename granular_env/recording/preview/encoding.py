"""Encoded messages of a log: schemas and contents in protobuf, and ROS 2 messages for rerun's plots in CDR.

Foxglove's message types come from its package. NumPy encodes points and numbers as whole arrays of bytes, because one object
per element would take longer than the run.
"""

from __future__ import annotations

import struct
from functools import cache
from typing import Any

import numpy as np

FRAME = "world"
CDR_HEAD = b"\x00\x01\x00\x00"
TEXT_NAME, TEXT = "std_msgs/msg/String", "string data\n"
NUMBERS_NAME = "std_msgs/msg/Float64MultiArray"
_LINE = "=" * 80
NUMBERS = f"""std_msgs/MultiArrayLayout layout
float64[] data
{_LINE}
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
{_LINE}
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
"""
# The protobuf fields of our messages `Block` and `Frames`; a `Frames` holds the values of its frames one after another.
_OWN_FIELDS = {
    "granular.Block": [("data", "TYPE_BYTES", "LABEL_OPTIONAL")],
    "granular.Frames": [
        ("place", "TYPE_SFIXED64", "LABEL_REPEATED"),
        ("ticks", "TYPE_SFIXED64", "LABEL_REPEATED"),
        ("values", "TYPE_DOUBLE", "LABEL_REPEATED"),
    ],
}
_POINT = np.dtype([("position", "<f4", 3), ("colour", "u1", 4)])


@cache
def point_cloud_schema() -> bytes:
    """Return the schema (FileDescriptorSet) of ``foxglove.PointCloud``: its protobuf file, preceded by the imported files."""
    from foxglove_schemas_protobuf import PointCloud_pb2
    from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

    files: dict[str, Any] = {}

    def add_file(file: Any) -> None:
        for needed in file.dependencies:
            add_file(needed)
        if file.name not in files:
            files[file.name] = FileDescriptorProto()
            file.CopyToProto(files[file.name])

    add_file(PointCloud_pb2.DESCRIPTOR)
    return FileDescriptorSet(file=files.values()).SerializeToString(deterministic=True)


@cache
def own_schema(name: str) -> bytes:
    """Return the schema (FileDescriptorSet) of ``granular.Block`` or ``granular.Frames``: a protobuf file with this message."""
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet

    package, _, title = name.partition(".")
    file = FileDescriptorProto(name=f"{package}/{title}.proto", package=package, syntax="proto3")
    message = file.message_type.add(name=title)
    for number, (field, kind, label) in enumerate(_OWN_FIELDS[name], 1):
        kinds = {"type": getattr(FieldDescriptorProto, kind), "label": getattr(FieldDescriptorProto, label)}
        message.field.add(name=field, number=number, **kinds)
    return FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)


def encode_point_cloud(nanoseconds: int, positions: np.ndarray, colours: np.ndarray) -> bytes:
    """Return an encoded ``foxglove.PointCloud`` message.

    The bytes of a colour are blue, green, red, alpha. Rerun reads them as four fields with these names; Foxglove uses the
    field ``rgba``, which is the same four bytes as one number.

    Args:
        nanoseconds: the time stamp in the message.
        positions: shape (n, 3) [m].
        colours: red, green, blue, alpha; shape (n, 4), uint8.
    """
    points = np.empty(len(positions), dtype=_POINT)
    points["position"], points["colour"] = positions, colours[:, [2, 1, 0, 3]]
    cloud = _empty_point_cloud()
    cloud.timestamp.FromNanoseconds(nanoseconds)
    cloud.data = points.tobytes()
    return cloud.SerializeToString(deterministic=True)


def _empty_point_cloud() -> Any:
    """Return a point cloud with frame, pose, stride and fields. Without a pose, viewers draw nothing."""
    from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField as Field
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
    from foxglove_schemas_protobuf.Pose_pb2 import Pose
    from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
    from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

    fields = [Field(name=axis, offset=4 * place, type=Field.FLOAT32) for place, axis in enumerate("xyz")]
    names = ("blue", "green", "red", "alpha")
    fields += [Field(name=name, offset=12 + place, type=Field.UINT8) for place, name in enumerate(names)]
    fields.append(Field(name="rgba", offset=12, type=Field.UINT32))
    pose = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
    return PointCloud(frame_id=FRAME, pose=pose, point_stride=_POINT.itemsize, fields=fields)


def encode_text(text: str) -> bytes:
    """Return an encoded ``std_msgs/String`` message."""
    data = text.encode() + b"\x00"
    return CDR_HEAD + struct.pack("<I", len(data)) + data


def encode_numbers(values: np.ndarray) -> list[bytes]:
    """Return a ``std_msgs/Float64MultiArray`` message with one number for each value, shape (n,)."""
    head = CDR_HEAD + struct.pack("<4I", 0, 0, 1, 0)  # no dimensions, offset 0, one number, padding
    return [head + value.tobytes() for value in values.astype("<f8")]
