"""A log in programs that know nothing of ours: what rerun, Foxglove and the `mcap` package find in it; a wave is seen."""

from __future__ import annotations

import json
import re
import tomllib
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import granular_env as ge
from granular_env.cli import main
from granular_env.components.drawables import Cells, Points
from granular_env.recording import open_log, recover
from granular_env.recording.preview.frame_selection import PreviewFrames, facts_of, scalar_values
from granular_env.recording.preview.messages import PreviewFacts, pictured
from granular_env.viewing import save_foxglove_layout

GRAINS, DURATION = 30, 2.5e-4


def make_chain(**parameters: Any) -> ge.Component:
    return ge.make("chain", **{"grains": GRAINS, "radius": 3e-3, "material": "steel", "left": "piston", **parameters})


def play(chain: ge.Component) -> None:
    """A step of the piston's velocity: a shock wave that goes through most of the chain, in two segments."""
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
    """Topic -> (log time, publish time, message), decoded with nothing but the schemas in the file."""
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
    """Positions (n, 3) and the packed colours (n, 4) as blue, green, red, alpha: where the message says that they are."""
    fields = {field.name: field for field in cloud.fields}
    data = np.frombuffer(cloud.data, dtype=np.uint8).reshape(-1, cloud.point_stride)

    def at(name: str, count: int) -> np.ndarray:
        return np.ascontiguousarray(data[:, fields[name].offset : fields[name].offset + count])

    assert [fields[axis].offset for axis in "xyz"] == [0, 4, 8] and fields["rgba"].type == 5
    return at("x", 12).view("<f4").reshape(-1, 3), at("rgba", 4)


def test_the_slow_clock_lasts_about_ten_seconds_and_simulated_time_stands_beside_it(log: Path) -> None:
    messages = decoded(log)
    for topic in ("/particles", "/preview", "/preview/spheres", "/energy[J]", "/scalars"):
        slow, simulated = (np.array([entry[place] for entry in messages[topic]]) for place in (0, 1))
        assert slow[0] == 0 and 8e9 <= slow[-1] <= 12.5e9
        assert simulated[-1] == pytest.approx((DURATION + 20 * make_chain().step_size) * 1e9, rel=1e-3)
        assert np.allclose(slow, slow[-1] * simulated / simulated[-1], atol=2.0)
        assert (np.diff(slow) >= 0).all()
    last = messages["/particles"][-1]
    assert last[1] == last[2].timestamp.seconds * 10**9 + last[2].timestamp.nanos


def test_the_motion_is_seen(log: Path) -> None:
    """Columns move by more than a tenth of the picture, grains by a percent; truly it is a thousandth."""
    messages = decoded(log)
    preview = [points_of(cloud)[0] for _, _, cloud in messages["/preview"]]
    true = [points_of(cloud)[0] for _, _, cloud in messages["/particles"]]
    length = np.ptp(true[0][:, 0]) + 6e-3
    grains = np.array([[(s.pose.position.x, s.pose.position.z) for s in scene.entities[0].spheres]
                       for _, _, scene in messages["/preview/spheres"]])  # fmt: skip
    truly = max(np.abs(positions[:, 0] - true[0][:, 0]).max() for positions in true)
    assert truly < 0.01 * length, "or else this test shows nothing"
    assert np.abs(grains[..., 0] - grains[0, :, 0]).max() > 0.03 * length
    assert np.abs(grains[..., 0] - grains[0, :, 0]).max() > 5 * truly
    tops = np.array([positions[:, 2].max() for positions in preview])
    assert np.ptp(tops) > 0.1 * length or tops[0] - grains[0, :, 1].max() > 0.1 * length
    highest = [positions[positions[:, 2].argmax(), 0] for positions in preview]
    assert max(highest) - min(highest) > 0.5 * length, "the highest column goes along the chain"


def test_grains_stay_in_order_and_beside_the_true_particles(log: Path) -> None:
    messages = decoded(log)
    lowest = min(points_of(cloud)[0][:, 2].min() for _, _, cloud in messages["/preview"])
    assert lowest > points_of(messages["/particles"][0][2])[0][:, 2].max() + 3e-3
    for _, _, scene in messages["/preview/spheres"]:
        (entity,) = scene.entities
        assert entity.frame_id == "world" and len(entity.spheres) == GRAINS
        assert (np.diff([sphere.pose.position.x for sphere in entity.spheres]) > 0).all()
        assert all(s.size.x == s.size.y == s.size.z == 6e-3 and s.pose.orientation.w == 1.0 for s in entity.spheres)


def test_true_particles_are_where_the_log_says(log: Path) -> None:
    times, displacement = open_log(log).series("displacement")
    reference = make_chain().drawables()[0].reference
    _, _, cloud = decoded(log)["/particles"][-1]
    assert np.allclose(points_of(cloud)[0][:, 0], reference[:, 0] + displacement[-1], atol=1e-8)


def test_colours_follow_the_velocity(log: Path) -> None:
    """Grey at rest, red to the right; the same four bytes as Foxglove's packed number and as rerun's four fields."""
    record, messages = open_log(log), decoded(log)["/particles"]
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


def test_scalars_are_grouped_by_unit_with_names_and_none_is_empty(log: Path) -> None:
    messages, chain = decoded(log), make_chain()
    topics = {topic for topic in messages if topic.startswith("/")}
    assert {"/energy[J]", "/velocity[m\u00b7s\u207b\u00b9]", "/momentum[kg\u00b7m\u00b7s\u207b\u00b9]"} <= topics
    assert not any("/" in topic[1:].replace("preview/spheres", "") or " " in topic for topic in topics)
    for topic in topics:
        if "[" in topic:
            names = messages[topic][0][2].layout.dim[0].label.split(", ")
            numbers = np.array([list(message.data) for _, _, message in messages[topic]])
            assert numbers.shape[1] == len(names) and (numbers != 0.0).any(axis=0).all()
            assert len({chain.variables[name].unit for name in names}) == 1
    _, energy = open_log(log).series("kinetic_energy")
    assert messages["/energy[J]"][0][2].layout.dim[0].label.split(", ")[0] == "kinetic_energy"
    assert messages["/energy[J]"][-1][2].data[0] == energy[-1] == messages["/scalars"][-1][2].kinetic_energy_J
    assert messages["/scalars"][-1][2].left_velocity_m_per_s == 5.0


def test_words_say_what_is_drawn(log: Path) -> None:
    ((_, _, about),) = decoded(log)["/about"]
    assert about.data.startswith("a-shock\n")
    for part in ("x as large", "1 s here = ", "m/s", "/energy[J]: [0] kinetic_energy"):
        assert part in about.data


def test_one_metadata_record_tells_experiment_parameters_units_and_versions(log: Path) -> None:
    with log.open("rb") as file:
        (record,) = make_reader(file).iter_metadata()
    assert record.name == "granular-env"
    texts = record.metadata
    assert tomllib.loads(texts["experiment"]) == {
        "name": "a-shock", "duration": DURATION, "component": {"type": "chain", "grains": GRAINS}
    }  # fmt: skip
    assert tomllib.loads(texts["parameters"])["grains"] == GRAINS and "radius = 0.003  # m\n" in texts["parameters"]
    assert "m/s: velocity, left_velocity" in texts["units"].split("; ") and "granular-env" in texts["versions"]


def test_a_log_that_was_not_closed_has_its_metadata_and_recovers_its_preview(log: Path, tmp_path: Path) -> None:
    chain = make_chain()
    recorder = ge.record(chain, tmp_path / "a.mcap", every=2e-6, variables=["displacement", "velocity"])
    play(chain)
    chain.ignore(recorder)
    recorder._write_end = lambda: None  # type: ignore[method-assign]
    recorder.close()
    content = (tmp_path / "a.mcap").read_bytes()
    assert b"radius = 0.003  # m" in content and b"/preview" not in content
    assert not open_log(tmp_path / "a.mcap").complete
    recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    found = decoded(tmp_path / "b.mcap")
    assert {"/preview", "/preview/spheres", "/energy[J]", "/about"} <= found.keys()
    with (tmp_path / "b.mcap").open("rb") as file:
        (record,) = make_reader(file).iter_metadata()
    assert "radius = 0.003  # m\n" in record.metadata["parameters"]


def test_messages_lie_in_the_order_of_time_in_each_chunk(tmp_path: Path) -> None:
    """Each batch holds several variables and hashes, whose last ticks differ."""
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


def test_the_preview_is_a_function_of_the_frames(log: Path) -> None:
    """A second run that is watched the same way gives the same bytes at the same times."""
    chain = make_chain()
    track = PreviewFrames(facts_of(chain, "a-shock"))
    ticks, before = open_log(log).ticks("velocity"), 0
    seen = []

    class Watcher:
        next_tick, stepped_once = 0, False

        def on_reset(self, component: ge.Component) -> None:
            nonlocal before
            before += 20 if self.stepped_once else 0
            if not self.stepped_once:
                seen.clear()
                track.forget_from(0)
            self.on_sample(component)

        def on_sample(self, component: ge.Component) -> None:
            number, tick = len(seen), component.tick
            if track.wants(number):
                scalars = scalar_values(component, track.names, component.balance_values())
                drawn = {name: component.peek(name) for name in ("displacement", "velocity")}
                track.add(number, round((before + tick) * component.step_size * 1e9), scalars, drawn)
            seen.append(before + tick)
            self.next_tick = tick + round(2e-6 / component.step_size)

        def on_step(self, *_: object) -> None:
            self.stepped_once = True

        def on_failure(self, *_: object) -> None: ...

    chain.observe(Watcher())
    play(chain)
    assert seen == ticks.tolist()
    expected = [(m.topic.name, m.log_time, m.publish_time, b"".join(m.parts)) for m in track.messages()]
    with log.open("rb") as file:
        found = [
            (channel.topic, message.log_time, message.publish_time, message.data)
            for _, channel, message in make_reader(file).iter_messages(log_time_order=False)
            if channel.topic.startswith("/")
        ]
    assert found == expected and len(found) > 300


def test_a_large_chain_has_a_preview_of_bounded_size_that_shows_the_wave(tmp_path: Path) -> None:
    chain = make_chain(grains=5000)
    with ge.record(chain, tmp_path / "a.mcap", every=5e-6, variables=["velocity"]):
        chain.reset(velocity={0: 5.0})
        chain.step(1e-4)
    messages = decoded(tmp_path / "a.mcap")
    points, _ = points_of(messages["/preview"][-1][2])
    true, _ = points_of(messages["/particles"][-1][2])
    assert len(true) == 5000 and len(points) <= 1000 and "/preview/spheres" not in messages
    assert np.ptp(points[:, 2]) > 0.1 * np.ptp(true[:, 0])


def test_a_component_without_particles_has_its_scalars_alone(tmp_path: Path) -> None:
    oscillator = ge.make("oscillator")
    with ge.record(oscillator, tmp_path / "a.mcap"):
        oscillator.reset(velocity=1.0)
        oscillator.step(1.0, force=2.0)
    topics = {topic for topic in decoded(tmp_path / "a.mcap") if topic.startswith("/")}
    assert topics == {
        "/about", "/scalars", "/energy[J]", "/force[N]", "/position[m]", "/velocity[m\u00b7s\u207b\u00b9]",
        "/momentum[kg\u00b7m\u00b7s\u207b\u00b9]",
    }  # fmt: skip


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
    points = np.vstack([points_of(cloud)[0] for topic in ("/particles", "/preview") for _, _, cloud in messages[topic]])
    # The camera looks along y: what it sees at the chain's distance is as high as this.
    seen = 2 * camera["distance"] * np.tan(np.radians(camera["fovy"] / 2))
    assert camera["near"] < 0.5 * camera["distance"] and seen / 2 < np.ptp(points[:, 2]) < seen
    assert np.abs(camera["targetOffset"][0] - points[:, 0].mean()) < 0.2 * np.ptp(points[:, 0])
    paths = [path for name, panel in panels.items() if name.startswith("Plot") for path in panel["paths"]]
    for path in paths:
        topic, _, place = path["value"].partition(".data[")
        topic = json.loads(topic)
        names = messages[topic][0][2].layout.dim[0].label.split(", ")
        assert names[int(place[:-1])] == path["label"]
    assert {path["label"] for path in paths} >= {"kinetic_energy", "left_velocity", "momentum"}


def leaves(mosaic: Any) -> list[str]:
    return [mosaic] if isinstance(mosaic, str) else leaves(mosaic["first"]) + leaves(mosaic["second"])


def test_a_log_without_a_preview_has_no_layout(log: Path, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(log.read_bytes()[:20_000])
    with pytest.raises(ge.GranularError, match="recover"):
        save_foxglove_layout(open_log(tmp_path / "cut.mcap"), tmp_path / "layout.json")
    assert not (tmp_path / "layout.json").exists()


def test_stock_rerun_draws_points_text_and_a_plot_for_each_unit(log: Path) -> None:
    chunk = pytest.importorskip("rerun.chunk")
    columns: dict[str, set[str]] = {}
    points = []
    for part in chunk.McapReader(str(log)).stream():
        batch = part.to_record_batch()
        columns.setdefault(str(part.entity_path), set()).update(batch.schema.names)
        if str(part.entity_path) == "/particles" and "Points3D:positions" in batch.schema.names:
            points += batch.column("Points3D:positions").to_pylist()
    drawn = {path for path, names in columns.items() if "Points3D:positions" in names}
    assert drawn == {"/particles", "/preview"} and all("Points3D:colors" in columns[path] for path in drawn)
    plotted = {unescaped(path) for path, names in columns.items() if "Scalars:scalars" in names}
    assert plotted == {topic for topic in decoded(log) if "[" in topic}, "no plot is empty"
    assert "TextDocument:text" in columns["/about"] and "granular-env" in columns["/__mcap_metadata"]
    assert len([frame for frame in points if frame]) >= 90 and len(points[-1]) == GRAINS


def unescaped(path: str) -> str:
    """An entity path as its topic was named: rerun writes what is no letter or digit with a backslash."""
    path = re.sub(r"\\u\{([0-9A-Fa-f]+)\}", lambda found: chr(int(found[1], 16)), path)
    return path.replace("\\", "")


def test_a_preview_keeps_what_its_messages_show_alone() -> None:
    """Further points have no topic, and what is too large for a preview has none."""
    grains = Points("grains", np.arange(3.0)[:, None], np.ones(3), "displacement", "velocity")
    others = Points("others", np.arange(2.0)[:, None], np.ones(2), "others_displacement")
    count = 20_001
    large = Cells("large", np.zeros((count, 2)), np.zeros((1, 4), dtype=np.int64), "stress")
    assert pictured([grains, others, large]) == (grains,)
    shapes = {"displacement": 3, "velocity": 3, "others_displacement": 2, "stress": count}
    facts = PreviewFacts("", (grains, others, large), dict.fromkeys(shapes, "m"), shapes, {})
    frames = PreviewFrames(facts)
    frames.add(0, 0, [], {name: np.zeros(size) for name, size in shapes.items()})
    assert sorted(frames.frames[0].drawn) == ["displacement", "velocity"]
    assert {message.topic.name for message in frames.messages()} >= {"/particles", "/preview"}
