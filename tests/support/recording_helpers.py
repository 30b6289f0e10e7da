"""Helpers for tests of logs: small recordings, logs rewritten with valid checksums, damage of every kind."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

import granular_env.components.catalogue as catalogue
from granular_env.components.component import Component
from granular_env.components.profiles import Profile
from granular_env.recording import record
from granular_env.recording.container import Container, Limits
from granular_env.recording.preview.film import PreviewMessage, Topic
from granular_env.recording.records import CLOSED, HEADER, INCIDENTS, Record, decode_record, record_kind
from granular_env.recording.writer import LogWriter

CHAIN = {"grains": 12, "radius": 3e-3, "material": "steel", "left": "free", "right": "free"}


def oscillator_log(path: Path, **options: object) -> Component:
    """Record a run with a reset, inputs of both kinds, and short and long steps; return the component."""
    component = catalogue.make("oscillator", stiffness=2.0)
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(velocity=1.0, position=0.25)
        for number in range(60):
            component.step(0.01, force=0.1 * (number % 7))
        component.step(1.5, force=Profile.triangle(1.0, 2.0, start=0.6))
        component.step(0.5)
    return component


def chain_log(path: Path, steps: int = 40, **options: object) -> Component:
    """Record a chain pushed by a force that changes at every step."""
    component = catalogue.make("chain", **CHAIN)
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(velocity={0: 1.0})
        for number in range(steps):
            component.step(3 * component.step_size, left_force=5.0 + number)
    return component


def rewrite_log(
    path: Path,
    out: Path,
    change: Callable[[Record], Record] = lambda record: record,
    change_index: Callable[[np.ndarray], np.ndarray] = lambda rows: rows,
) -> None:
    """Write a log with every record changed by `change`, and with valid checksums, numbers and index.

    `change_index` changes the index of the new log.
    """
    writer, container, preview = LogWriter(out, overwrite=True), Container(path, Limits(str(path))), []
    try:
        for _, (topic, message) in container.all_messages():
            kind = record_kind(topic)
            if kind is None:
                any_topic = Topic(topic, "any", "protobuf", b"")
                preview.append(PreviewMessage(any_topic, message.log_time, message.publish_time, message.data))
                continue
            new = change(decode_record(message.data, kind))
            if new.kind == INCIDENTS and new.detail == CLOSED:
                writer.add_preview(preview)
                writer.rows = [tuple(row) for row in change_index(np.array(writer.rows, dtype=np.int64)).tolist()]
                facts = {name: value for name, value in new.header.items() if name != "incident"}
                writer.finish(new.segment, new.last, message.log_time, facts)
            elif new.kind == HEADER:
                writer.add_header(new)
            else:
                writer.add_record(new, message.log_time)
    finally:
        container.close()
        writer.abandon()


def film_topics(path: Path) -> dict[str, Topic]:
    """Return the channels of a log for stock viewers, read by the stock reader."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    found = [(channel.topic, summary.schemas[channel.schema_id]) for channel in summary.channels.values()]
    return {topic: Topic(topic, schema.name, schema.encoding, schema.data) for topic, schema in found}


def change_arrays(record: Record, **arrays: np.ndarray) -> Record:
    """Return a record with some arrays replaced."""
    return dataclasses.replace(record, arrays={**record.arrays, **arrays})


def mutate_bytes(data: bytes, other: bytes, chance: random.Random) -> bytes:
    """Return bytes with one kind of damage: flipped bits, cut, duplicated or exchanged pieces, or inflated sizes."""
    damaged = bytearray(data)
    kind = chance.randrange(7)
    place = chance.randrange(len(damaged))
    length = chance.randrange(1, 200)
    if kind == 0:
        damaged[place] ^= 1 << chance.randrange(8)
    elif kind == 1:
        del damaged[place:]
    elif kind == 2:
        begin = chance.randrange(len(other))
        damaged[place : place + length] = other[begin : begin + length]
    elif kind == 3:
        del damaged[place : place + length]
    elif kind == 4:
        damaged[place:place] = damaged[place : place + length]
    elif kind == 5:
        huge = chance.choice([2**63 - 1, 2**64 - 1, 2**40, 2**32 - 1, 0])
        damaged[place : place + 8] = huge.to_bytes(8, "little")
    else:
        for _ in range(chance.randrange(1, 40)):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
    return bytes(damaged)
