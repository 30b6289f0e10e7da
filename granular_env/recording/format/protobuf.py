"""Protobuf messages: the block that holds a log's exact content, and three for stock viewers. No protoc is needed.

Foxglove's messages are those of its package. Points, spheres and named numbers are laid out by numpy as whole arrays of bytes,
after one message that protobuf wrote: building each as an object would take longer than the run that they show.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np

from .records import varint

FRAME = "world"
Parts = list[bytes | memoryview]


@cache
def block_schema() -> bytes:
    """Return the FileDescriptorSet of ``granular.Block``: one field of bytes."""
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto

    return _own_schema("Block", ["data"], FieldDescriptorProto.TYPE_BYTES)


def scalars_schema(names: Sequence[str]) -> bytes:
    """Return the FileDescriptorSet of ``granular.Scalars``: one double for each name."""
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto

    return _own_schema("Scalars", names, FieldDescriptorProto.TYPE_DOUBLE)


@cache
def point_cloud_schema() -> bytes:
    """Return the FileDescriptorSet of ``foxglove.PointCloud``."""
    from foxglove_schemas_protobuf import PointCloud_pb2

    return _file_set(PointCloud_pb2.DESCRIPTOR)


@cache
def scene_update_schema() -> bytes:
    """Return the FileDescriptorSet of ``foxglove.SceneUpdate``."""
    from foxglove_schemas_protobuf import SceneUpdate_pb2

    return _file_set(SceneUpdate_pb2.DESCRIPTOR)


def _own_schema(name: str, fields: Iterable[str], kind: Any) -> bytes:
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet

    file = FileDescriptorProto(name=f"granular/{name}.proto", package="granular", syntax="proto3")
    message = file.message_type.add(name=name)
    for number, field in enumerate(fields, 1):
        message.field.add(name=field, number=number, type=kind, label=FieldDescriptorProto.LABEL_OPTIONAL)
    return FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)


def _file_set(descriptor: Any) -> bytes:
    """Return a file of messages with all that it imports, each before what needs it."""
    from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

    files: dict[str, Any] = {}

    def add(file: Any) -> None:
        for needed in file.dependencies:
            add(needed)
        if file.name not in files:
            files[file.name] = FileDescriptorProto()
            file.CopyToProto(files[file.name])

    add(descriptor)
    return FileDescriptorSet(file=files.values()).SerializeToString(deterministic=True)


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
    points["position"] = positions
    for channel, place in zip(range(4), (2, 1, 0, 3), strict=True):
        points["colour"][:, channel] = colours[:, place]
    # The points are the last field: protobuf would copy them twice.
    data = points.view(np.uint8).data
    return [_field(1, _stamp(nanoseconds)) + _point_cloud_head() + b"\x32" + varint(len(data)), data]


@cache
def _point_cloud_head() -> bytes:
    """Return frame, pose, stride and fields. Viewers draw nothing where the pose is not set."""
    from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField as Field
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

    fields = [Field(name=axis, offset=4 * place, type=Field.FLOAT32) for place, axis in enumerate("xyz")]
    names = ("blue", "green", "red", "alpha")
    fields += [Field(name=name, offset=12 + place, type=Field.UINT8) for place, name in enumerate(names)]
    fields.append(Field(name="rgba", offset=12, type=Field.UINT32))
    return PointCloud(frame_id=FRAME, pose=_pose(), point_stride=_POINT.itemsize, fields=fields).SerializeToString()


def _pose(**position: float) -> Any:
    from foxglove_schemas_protobuf.Pose_pb2 import Pose
    from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
    from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

    return Pose(position=Vector3(**position), orientation=Quaternion(w=1.0))


# Steps of a colour's channel: numbers of few digits compress well.
_TINTS = 64.0
# What stands in the message that the others are made after; no number of these is anywhere else in it.
_PLACE, _SIZE, _COLOUR = {"x": 2.0, "y": 3.0, "z": 4.0}, {"x": 5.0, "y": 6.0, "z": 7.0}, {"r": 8.0, "g": 9.0, "b": 10.0}


def encode_spheres(nanoseconds: int, positions: np.ndarray, radius: np.ndarray, colours: np.ndarray) -> Parts:
    """Return one ``foxglove.SceneUpdate`` with one entity: a sphere of its size for each position.

    Args:
        nanoseconds: the time stamp.
        positions: shape (n, 3) [m].
        radius: shape (n,) [m].
        colours: red, green, blue, alpha; shape (n, 4), uint8; alpha is not used.
    """
    sphere = _sphere()
    # As bytes: numpy copies no more of a record than its named numbers.
    spheres = np.tile(sphere.view(np.uint8), len(positions)).view(sphere.dtype)
    for place, axis in enumerate("xyz"):
        spheres[axis], spheres[f"size {axis}"] = positions[:, place], 2.0 * radius
    for place, channel in enumerate("rgb"):
        spheres[channel] = np.rint(colours[:, place] * (_TINTS / 255.0)) / _TINTS
    entity = _field(1, _stamp(nanoseconds)) + _field(2, FRAME.encode()) + _field(3, b"spheres")
    data = spheres.view(np.uint8).data
    return [b"\x12" + varint(len(entity) + len(data)) + entity, data]


@cache
def _sphere() -> np.ndarray:
    """Return a ``SpherePrimitive`` as a field of its entity, shape (1,), with names for those of its bytes that are numbers."""
    from foxglove_schemas_protobuf.Color_pb2 import Color
    from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
    from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
    from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

    sphere = SpherePrimitive(pose=_pose(**_PLACE), size=Vector3(**_SIZE), color=Color(**_COLOUR, a=1.0))
    written = SceneEntity(spheres=[sphere]).SerializeToString()
    numbers = {**_PLACE, **{f"size {axis}": number for axis, number in _SIZE.items()}, **_COLOUR}
    starts = [written.index(np.array(number, dtype="<f8").tobytes()) for number in numbers.values()]
    layout = {"names": list(numbers), "formats": ["<f8"] * len(numbers), "offsets": starts, "itemsize": len(written)}
    return np.frombuffer(written, dtype=np.dtype(layout))  # type: ignore[arg-type]


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
