"""A log in stock viewers: contents as read by rerun, Foxglove and the `mcap` package; a visible wave."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from support.coupled_tools import layers

import granular_env as ge
from granular_env.cli import main
from granular_env.recording import open_log, recover
from granular_env.recording.preview import clouds
from granular_env.viewing.scene_builder import load_scene
from granular_env.viewing.scene_scales import make_scales

GRAINS, DURATION = 30, 2.5e-4
# The numbers of the log that are plotted.
NUMBERS = {"/energy/kinetic_energy", "/energy/potential_energy", "/energy/input_work", "/velocity/left_velocity"}


def make_chain(**parameters: Any) -> ge.Component:
    return ge.make("chain", **{"grains": GRAINS, "radius": 3e-3, "material": "steel", "left": "piston", **parameters})


def play(chain: ge.Component) -> None:
    """Return a log with a step of the piston's velocity: a shock wave through most of the chain, in two segments."""
    chain.reset(velocity={0: 1.0})
    chain.step(20 * chain.step_size)
    chain.reset(velocity={0: 5.0})
    chain.step(DURATION)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("logs") / "shock.mcap"
    chain = make_chain()
    experiment = {"name": "a-shock", "duration": DURATION, "component": {"type": "chain", "grains": GRAINS}, "seed": None}
    with ge.record(chain, path, every=2e-6, variables=["displacement", "velocity"], experiment=experiment):
        play(chain)
    return path


def decoded(path: Path) -> dict[str, list[tuple[int, int, Any]]]:
    """Return topic -> (log time, publish time, message), decoded only with the schemas in the file."""
    ros, classes, found = DecoderFactory(), {}, defaultdict(list)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            if schema.name not in classes:
                classes[schema.name] = protobuf_class(schema) if schema.encoding == "protobuf" else None
            kind = classes[schema.name]
            if kind is not None:
                content = kind.FromString(message.data)
            else:
                content = ros.decoder_for("cdr", schema)(message.data)  # type: ignore[misc]
            found[channel.topic].append((message.log_time, message.publish_time, content))
    return found


def protobuf_class(schema: Any) -> Any:
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))


def points_of(cloud: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and packed colours (n, 4: blue, green, red, alpha) from the offsets stated in the message."""
    fields = {field.name: field for field in cloud.fields}
    data = np.frombuffer(cloud.data, dtype=np.uint8).reshape(-1, cloud.point_stride)

    def at(name: str, count: int) -> np.ndarray:
        return np.ascontiguousarray(data[:, fields[name].offset : fields[name].offset + count])

    assert [fields[axis].offset for axis in "xyz"] == [0, 4, 8] and fields["rgba"].type == 5
    return at("x", 12).view("<f4").reshape(-1, 3), at("rgba", 4)


def test_the_slow_clock_lasts_about_ten_seconds_and_simulated_time_stands_beside_it(log: Path) -> None:
    messages = decoded(log)
    for topic in ("/points/grains", "/energy/kinetic_energy"):
        slow, simulated = (np.array([entry[place] for entry in messages[topic]]) for place in (0, 1))
        assert slow[0] == 0 and 8e9 <= slow[-1] <= 12.5e9
        assert simulated[-1] == pytest.approx((DURATION + 20 * make_chain().step_size) * 1e9, rel=1e-3)
        assert np.allclose(slow, slow[-1] * simulated / simulated[-1], atol=2.0)
        assert (np.diff(slow) >= 0).all()
    last = messages["/points/grains"][-1]
    assert last[1] == last[2].timestamp.seconds * 10**9 + last[2].timestamp.nanos


def test_recorded_variables_are_read_with_the_schema_alone(log: Path) -> None:
    """Ticks and values of each variable are packed numbers; unit and shape are in the metadata of its channel."""
    found = decoded(log)["granular/frames/velocity"]
    values = np.concatenate([np.array(message.values).reshape(-1, GRAINS) for _, _, message in found])
    assert values.tobytes() == open_log(log).series("velocity")[1].tobytes()
    assert sum(len(message.ticks) for _, _, message in found) == len(values)
    with log.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    texts = {channel.topic: channel.metadata for channel in summary.channels.values()}["granular/frames/velocity"]
    assert texts["unit"] == "m/s" and texts["shape"] == f"[{GRAINS}]"


def test_the_motion_is_seen(log: Path) -> None:
    """Grains move by more than a hundredth of the picture for a true motion of a thousandth, and keep their order."""
    messages, times = decoded(log)["/points/grains"], open_log(log)
    drawn = np.array([points_of(cloud)[0][:, 0] for _, _, cloud in messages])
    truly, length = np.abs(times.series("displacement")[1]).max(), np.ptp(drawn[0])
    assert truly < 0.01 * length, "or else this test shows nothing"
    assert np.abs(drawn - drawn[0]).max() > max(0.03 * length, 5 * truly)
    assert (np.diff(drawn, axis=1) > 0.0).all()
    highest = [points_of(cloud)[0][:, 2].argmax() for _, _, cloud in messages]
    assert max(highest) > GRAINS // 2, "the velocity is a height, and goes along the chain"


def test_one_metadata_record_has_the_entries_of_the_header(log: Path) -> None:
    with log.open("rb") as file:
        (record,) = make_reader(file).iter_metadata()
    assert record.name == "granular-env"
    assert json.loads(record.metadata["experiment"])["name"] == "a-shock"
    assert json.loads(record.metadata["parameters"])["grains"] == GRAINS
    assert "granular-env" in json.loads(record.metadata["versions"])


def test_a_recovered_log_has_its_preview(log: Path, tmp_path: Path) -> None:
    content = log.read_bytes()
    (tmp_path / "a.mcap").write_bytes(content[: content.index(b"/about")])
    assert not open_log(tmp_path / "a.mcap").complete
    recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert {"/points/grains", "/energy/kinetic_energy", "/about"} <= decoded(tmp_path / "b.mcap").keys()


def test_colours_follow_the_velocity(log: Path) -> None:
    """Grey at rest, red to the right; Foxglove's packed number and rerun's four fields use the same four bytes."""
    record, messages = open_log(log), decoded(log)["/points/grains"]
    _, simulated, cloud = messages[len(messages) // 3]
    velocity, largest = record.get("velocity", simulated * 1e-9), np.abs(record.series("velocity")[1]).max()
    seen = np.vstack([points_of(cloud)[1] for _, _, cloud in messages])
    assert len(np.unique(seen, axis=0)) > 15
    blue, green, red, alpha = points_of(cloud)[1].T.astype(int)
    assert (alpha == 255).all()
    fast, still = velocity > 0.5 * largest, np.abs(velocity) < 1e-3
    assert fast.any() and (red[fast] > blue[fast] + 40).all() and still.any() and (red[still] == blue[still]).all()
    offsets = {field.name: field.offset for field in messages[0][2].fields}
    assert [offsets[name] - offsets["rgba"] for name in ("blue", "green", "red", "alpha")] == [0, 1, 2, 3]


def test_numbers_are_named_and_grouped_by_quantity(log: Path) -> None:
    """Each number that changes is a topic with its unit; zeros, constants and small numbers are not plotted."""
    messages = decoded(log)
    with log.open("rb") as file:
        channels = {one.topic: one for one in make_reader(file).get_summary().channels.values()}  # type: ignore[union-attr]
    numbers = {topic for topic in messages if topic.count("/") == 2 and topic.startswith("/")} - {"/points/grains"}
    assert numbers == NUMBERS
    for topic in numbers:
        assert channels[topic].metadata["unit"] == {"energy": "J", "velocity": "m/s"}[topic.split("/")[1]]
        assert len({message.data[0] for _, _, message in messages[topic]}) > 1
    assert messages["/energy/kinetic_energy"][-1][2].data[0] == open_log(log).series("kinetic_energy")[1][-1]
    assert "Units: energy J, velocity m/s." in messages["/about"][0][2].data


def test_broken_links_are_bright_dots_and_intact_ones_absent(tmp_path: Path) -> None:
    """Two halves of a row of discs move apart; the link between them breaks while their ends are close."""
    discs = ge.make("discs", rows=1, columns=4, clearance=0.01, breaking_strain=1e-3)
    with ge.record(discs, tmp_path / "a.mcap", every=discs.step_size, variables=["displacement", "speed", "linked"]):
        discs.reset(velocity=np.array([[-1.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 0.0]]))
        discs.step(40 * discs.step_size)
    messages = decoded(tmp_path / "a.mcap")
    dots = [points_of(cloud) for _, _, cloud in messages["/links/links"]]
    assert len(dots[0][0]) == 0 and max(len(places) for places, _ in dots) == 1
    assert next(colours[0] for _, colours in dots if len(colours)).tolist() == [255, 0, 190, 255]
    text = messages["/about"][0][2].data
    assert "Violet dots: broken links." in text and "speed from 0 (grey) to" in text, "a speed has no negative half"


def test_bodies_in_a_plane_stand_upright_with_the_scales_of_our_viewer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A grid and automata have one colour scale. The factor follows from all particles, even if few are drawn."""
    monkeypatch.setattr(clouds, "MOST_PLACES", 20)
    coupled = layers()
    names = [f"{part}_{name}" for part in ("grid", "automata") for name in ("speed", "displacement")]
    with ge.record(coupled, tmp_path / "a.mcap", every=5 * coupled.step_size, variables=names):
        coupled.reset(grid_velocity=1e-3 * np.random.default_rng(1).standard_normal(coupled.variables["grid_velocity"].shape))
        coupled.step(100 * coupled.step_size)
    messages = decoded(tmp_path / "a.mcap")
    assert "/points/nodes" not in messages, "cells show the nodes"
    for topic in ("/cells/grid", "/points/automata"):
        places, colours = points_of(messages[topic][-1][2])
        assert not places[:, 1].any() and np.ptp(places[:, 2]) > 0.0 and len(np.unique(colours, axis=0)) > 1
    with open_log(tmp_path / "a.mcap") as log:
        scales = make_scales(load_scene(log))
    assert scales is not None
    text = messages["/about"][0][2].data
    assert f"Displacements are {scales.exaggeration:g} times larger." in text
    assert f"grid_speed, automata_speed from 0 (grey) to {scales.colour_limit:g} m/s (red)" in text


def test_messages_lie_in_the_order_of_time_in_each_chunk(tmp_path: Path) -> None:
    """Each batch contains several variables and hashes with different last ticks."""
    chain = make_chain(grains=200)
    with ge.record(chain, tmp_path / "a.mcap", every=chain.step_size, hash_every=7, snapshot_every=50 * chain.step_size):
        chain.reset(velocity={0: 5.0})
        chain.step(1500 * chain.step_size)
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        assert len(reader.get_summary().chunk_indexes) > 8  # type: ignore[union-attr]
        times = defaultdict(list)
        for _, channel, message in reader.iter_messages(log_time_order=False):
            times["exact" if channel.topic.startswith("granular/") else "preview"].append(message.log_time)
    for found in times.values():
        assert found == sorted(found)


def test_the_foxglove_layout_shows_what_is_in_the_log(log: Path, tmp_path: Path) -> None:
    assert main(["view", str(log), "--foxglove-layout", str(tmp_path / "layout.json")]) == 0
    layout = json.loads((tmp_path / "layout.json").read_text())
    messages, panels = decoded(log), layout["configById"]
    assert {name.partition("!")[0] for name in panels} == {"3D", "RawMessages", "Plot"}
    assert sorted(leaves(layout["layout"])) == sorted(panels)
    scene = panels["3D!preview"]
    for topic, settings in scene["topics"].items():
        assert topic in messages and settings["visible"]
    camera = scene["cameraState"]
    points = np.vstack([points_of(cloud)[0] for topic in ("/points/grains",) for _, _, cloud in messages[topic]])
    # The camera looks along y; this is its visible height at the chain's distance.
    seen = 2 * camera["distance"] * np.tan(np.radians(camera["fovy"] / 2))
    assert camera["near"] < 0.5 * camera["distance"] and np.ptp(points[:, 2]) < seen and np.ptp(points[:, 0]) < 2 * seen
    assert np.abs(camera["targetOffset"][0] - points[:, 0].mean()) < 0.2 * np.ptp(points[:, 0])
    plots = [panel for name, panel in panels.items() if name.startswith("Plot")]
    assert [panel["foxglovePanelTitle"] for panel in plots] == ["energy [J]", "velocity [m/s]"]
    paths = [path for panel in plots for path in panel["paths"]]
    assert {path["value"].removesuffix(".data[0]") for path in paths} == NUMBERS <= messages.keys()
    assert all(path["value"].endswith(f"/{path['label']}.data[0]") for path in paths)


def leaves(mosaic: Any) -> list[str]:
    return [mosaic] if isinstance(mosaic, str) else leaves(mosaic["first"]) + leaves(mosaic["second"])


def test_stock_rerun_draws_points_text_and_a_plot_for_each_number(log: Path) -> None:
    chunk = pytest.importorskip("rerun.chunk")
    columns: dict[str, set[str]] = {}
    points = []
    for part in chunk.McapReader(str(log)).stream():
        batch = part.to_record_batch()
        columns.setdefault(str(part.entity_path), set()).update(batch.schema.names)
        if str(part.entity_path) == "/points/grains" and "Points3D:positions" in batch.schema.names:
            points += batch.column("Points3D:positions").to_pylist()
    drawn = {path for path, names in columns.items() if "Points3D:positions" in names}
    assert drawn == {"/points/grains"} and "Points3D:colors" in columns["/points/grains"]
    plotted = {path for path, names in columns.items() if "Scalars:scalars" in names}
    assert plotted == NUMBERS
    assert "TextDocument:text" in columns["/about"] and "granular-env" in columns["/__mcap_metadata"]
    assert len([frame for frame in points if frame]) >= 50 and len(points[-1]) == GRAINS
