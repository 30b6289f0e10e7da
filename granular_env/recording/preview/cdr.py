"""The ROS 2 messages that stock rerun draws without a layout, in CDR, little-endian: arrays of numbers, and texts.

Each is a handful of fields, laid out by hand: `mcap_ros2`, which the tests read them with, takes 12 microseconds for a message
of three numbers and 60 for one of ten, where these take 2 at most.
"""

from __future__ import annotations

import struct

import numpy as np

HEAD = b"\x00\x01\x00\x00"

TEXT_NAME = "std_msgs/msg/String"
TEXT = "string data\n"

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


def encode_text(text: str) -> bytes:
    """Return one ``std_msgs/String``."""
    body = bytearray()
    _add_string(body, text)
    return HEAD + bytes(body)


def encode_numbers(label: str, rows: np.ndarray) -> list[bytes]:
    """Return one ``std_msgs/Float64MultiArray`` for each row of `rows`, shape (messages, numbers).

    Args:
        label: what stands in the message's only dimension; what the numbers are.
        rows: the numbers.
    """
    count = rows.shape[1]
    body = bytearray()
    _add_count(body, 1)
    _add_string(body, label)
    for value in (count, count, 0, count):
        _add_count(body, value)
    body += bytes(-len(body) % 8)
    head = HEAD + bytes(body)
    return [head + row.tobytes() for row in np.ascontiguousarray(rows, dtype="<f8")]


def label_of_numbers(data: bytes) -> str:
    """Return the label of a message that `encode_numbers` wrote."""
    (length,) = struct.unpack_from("<I", data, 8)
    return data[12 : 12 + length - 1].decode()


def _add_count(body: bytearray, count: int) -> None:
    body += bytes(-len(body) % 4)
    body += struct.pack("<I", count)


def _add_string(body: bytearray, text: str) -> None:
    data = text.encode() + b"\x00"
    _add_count(body, len(data))
    body += data
