"""For the tests of logs: small recordings, a log rewritten with valid checksums, damage of every kind."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

import granular_env.components.catalogue as catalogue
from granular_env.components.component import Component
from granular_env.components.errors import LogError
from granular_env.components.profiles import Profile
from granular_env.components.support.serialization import canonical_json
from granular_env.recording import record
from granular_env.recording.container.limits import Limits
from granular_env.recording.container.reader import McapReader
from granular_env.recording.format.metadata import metadata_of_log
from granular_env.recording.format.records import CLOSED, HEADER, INCIDENTS, TOPICS, Record, decode, log_identity
from granular_env.recording.preview.messages import PreviewMessage, Topic
from granular_env.recording.recorder.log_file import create
from granular_env.recording.recorder.log_writer import LogWriter
from granular_env.recording.replay.recovery import parameter_model

CHAIN = {"grains": 12, "radius": 3e-3, "material": "steel", "left": "free", "right": "free"}


def oscillator_log(path: Path, **options: object) -> Component:
    """A run with a reset, inputs of both kinds, short and long steps; the component as it is at the end."""
    component = catalogue.make("oscillator", stiffness=2.0)
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(velocity=1.0, position=0.25)
        for number in range(60):
            component.step(0.01, force=0.1 * (number % 7))
        component.step(1.5, force=Profile.triangle(1.0, 2.0, start=0.6))
        component.step(0.5)
    return component


def chain_log(path: Path, steps: int = 40, **options: object) -> Component:
    """A chain pushed by a force that changes at every step."""
    component = catalogue.make("chain", **CHAIN)
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(velocity={0: 1.0})
        for number in range(steps):
            component.step(3 * component.step_size, left_force=5.0 + number)
    return component


def rewrite(
    path: Path,
    out: Path,
    change: Callable[[Record], Record] = lambda record: record,
    change_preview: Callable[[bytes], bytes] = lambda data: data,
    shift: int = 0,
    change_texts: Callable[[dict[str, str]], dict[str, str]] = lambda texts: texts,
) -> None:
    """The same log with every record put through `change`, every message of the preview through `change_preview`, and `shift`
    ns added to each time; every checksum, number and index is made right again."""
    sink, container = LogWriter(out, create(out, overwrite=True)), McapReader(path, Limits(str(path)))
    log, preview = None, []
    for chunk in range(container.chunk_count):
        for message in container.messages(chunk):
            kind, time = TOPICS.get(message.topic), message.nanoseconds + shift
            if kind is None:
                topic = Topic(message.topic, "any", "protobuf", b"")
                preview.append(PreviewMessage(topic, time, message.published, [change_preview(bytes(message.data))]))
                continue
            log = log_identity(message.data) if kind == HEADER else log
            new = change(decode(message.data, kind, None if kind == HEADER else log))
            if new.kind == INCIDENTS and new.detail == CLOSED:
                sink.add_preview(preview)
                new = dataclasses.replace(new, arrays={"index": sink.rows})
            sink.add(new, time)
            if new.kind == HEADER:
                sink.flush()
                header = json.loads(canonical_json(dict(new.header)))
                with contextlib.suppress(LogError):  # a header that lies may describe nothing
                    texts = metadata_of_log(header, parameter_model(header.get("component")))
                    sink.add_metadata(change_texts(texts))
    container.close()
    sink.finish()


def film_topics(path: Path) -> dict[str, Topic]:
    """The channels of a log that stock viewers draw, read by the stock reader."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    found = [(channel.topic, summary.schemas[channel.schema_id]) for channel in summary.channels.values()]
    return {topic: Topic(topic, schema.name, schema.encoding, schema.data) for topic, schema in found}


def changed(record: Record, **arrays: np.ndarray) -> Record:
    """A record with some arrays replaced."""
    return dataclasses.replace(record, arrays={**record.arrays, **arrays})


def mutated(data: bytes, other: bytes, chance: random.Random) -> bytes:
    """Bytes with one kind of damage: flipped bits, cut, doubled or exchanged pieces, sizes blown up."""
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
