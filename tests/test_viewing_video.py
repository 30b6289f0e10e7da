"""Films: frames, sizes and contents of MP4 and GIF files; overlays of forces, vectors and stresses; errors."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import granular_env as ge
from granular_env.components.drawables import Links
from granular_env.components.errors import ParameterError
from granular_env.viewing.scene_builder import load_scene

pytest.importorskip("matplotlib", reason="the extra `view` is not installed")

from granular_env.viewing.figures import overlays, video
from granular_env.viewing.figures.keys import displacement_notes
from granular_env.viewing.figures.plane import draw_plane, load_plane

ROCK = {"density": 2700.0, "young": 6e10, "poisson": 0.25}
# Duration of the compression [s], in which a wave at 5 km/s crosses the body.
DURATION = 1.2e-5


@pytest.fixture(scope="module")
def pressed_log(tmp_path_factory: Any) -> Any:
    """Return the log of automata that a moving side compresses."""
    path = tmp_path_factory.mktemp("pressed") / "pressed.mcap"
    automata = ge.make(
        "automata", shape={"name": "rectangle", "width": 0.06, "height": 0.02}, diameter=2e-3, packing="square", material=ROCK,
        boundaries={"left": "velocity", "right": "fixed"},
    )  # fmt: skip
    variables = ["displacement", "velocity", "rotation", "speed", "linked", "link_force", "stress"]
    with ge.record(automata, path, every=1e-6, variables=variables):
        automata.step(DURATION, left_velocity=[1.0, 0.0])
    return ge.open_log(path)


@pytest.fixture(scope="module")
def chain_log(tmp_path_factory: Any) -> Any:
    """Return the log of a row of grains behind a piston."""
    path, chain = tmp_path_factory.mktemp("chain") / "chain.mcap", ge.make("chain", grains=20, left="piston")
    with ge.record(chain, path, every=1e-6):
        chain.step(5e-5, left_velocity=5.0)
    return ge.open_log(path)


def read_mp4(path: Path) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return the metadata and the pictures of a film, each of shape (height, width, 3)."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra `video` is not installed")
    frames = ffmpeg.read_frames(str(path))
    facts = next(frames)
    width, height = facts["size"]
    return facts, [np.frombuffer(one, np.uint8).reshape(height, width, 3) for one in frames]


def test_an_mp4_has_the_requested_pictures_and_shows_the_motion(pressed_log: Any, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="the extra `video` is not installed")
    told: list[float] = []
    size, rate = (320, 240), 10.0
    path = ge.viewing.video(pressed_log, tmp_path / "film.mp4", frame_rate=rate, duration=2.0, size=size, progress=told.append)
    facts, pictures = read_mp4(path)
    assert facts["size"] == size and facts["fps"] == rate and len(pictures) == 20
    # The wave changes many pixels by more than lossy coding does.
    assert (np.abs(pictures[-1].astype(int) - pictures[0]) > 60).mean() > 0.02
    assert told == sorted(told) and told[-1] == 1.0
    assert [one.name for one in tmp_path.iterdir()] == ["film.mp4"]


def test_a_gif_keeps_pale_bodies_and_rare_colours(tmp_path: Path) -> None:
    picture = np.full((200, 300, 3), 255, np.uint8)
    picture[20:180, 20:280] = 247
    picture[100:140] = np.linspace([103, 0, 31], [247, 247, 247], 300).astype(np.uint8)
    picture[190:194, 10:20] = [178, 24, 43]
    picture[190:194, 30:40] = [33, 102, 172]
    video._write_gif(tmp_path / "a.gif", iter([picture, picture]), 10.0, 2)
    with Image.open(tmp_path / "a.gif") as film:
        drawn = np.asarray(film.convert("RGB")).astype(int)
    assert np.abs(drawn - picture).max() < 12 and (drawn[0, 0] == 255).all() and drawn[25, 25].max() < 250


def test_a_gif_plays_as_long_as_requested_and_its_frames_differ(chain_log: Any, tmp_path: Path) -> None:
    path = ge.viewing.video(chain_log, str(tmp_path / "film.gif"), frame_rate=30.0, duration=1.0)
    with Image.open(path) as film:
        first, count = np.asarray(film.convert("RGB")), film.n_frames
        durations = []
        for frame in range(count):
            film.seek(frame)
            durations.append(film.info["duration"])
        last = np.asarray(film.convert("RGB"))
        assert film.info["loop"] == 0 and film.size[0] % 2 == film.size[1] % 2 == 0
    assert sum(durations) == 1000 and count == 30 and set(durations) == {30, 40} and np.mean(first != last) > 0.001


def test_force_chains_are_wide_where_links_are_compressed(pressed_log: Any) -> None:
    scene_data, links = load_scene(pressed_log), next(one for one in pressed_log.drawables if isinstance(one, Links))
    plane = load_plane(pressed_log, scene_data, [0.0, DURATION], show=["link_force"])
    assert plane is not None and plane.is_pale and plane.colour_scales == ()
    [chains] = plane.overlays
    forces = pressed_log.series("link_force")[1][-1]
    np.testing.assert_array_equal(chains.values[-1], forces)
    figure = draw_plane(plane)
    drawn = figure.axes[1].collections[-1]
    # One quadrilateral for each force above 3 % of the limit; the widest has the width of the key.
    assert len(drawn.get_paths()) == np.count_nonzero(np.abs(forces) > 0.03 * chains.limit) > 10
    widths = [np.hypot(*(path.vertices[3] - path.vertices[0])) for path in drawn.get_paths()]
    assert max(widths) == pytest.approx(chains.largest[1]) and len(links.pairs) == len(forces)
    assert len(figure.axes[0].collections[-1].get_paths()) == 0  # at the start nothing is loaded
    [compression, *_] = chains.key()
    assert "compression" in compression[1] and "N" in compression[1]


def test_crosses_are_the_principal_stresses() -> None:
    # Uniaxial tension along 30 degrees, pure shear, and hydrostatic pressure; the out-of-plane stress has no influence.
    turn = np.deg2rad(30.0)
    tension = [3.0 * np.cos(turn) ** 2, 3.0 * np.sin(turn) ** 2, 3.0 * np.sin(turn) * np.cos(turn)]
    stresses = np.array([tension, [0.0, 0.0, 2.0], [-1.0, -1.0, 0.0]])
    principal, directions = overlays.principal_stresses(stresses)
    np.testing.assert_allclose(principal, [[3.0, 0.0], [2.0, -2.0], [-1.0, -1.0]], atol=1e-14)
    np.testing.assert_allclose(directions[0, 0], [np.cos(turn), np.sin(turn)])
    np.testing.assert_allclose(directions[1, 0], [np.sqrt(0.5), np.sqrt(0.5)])
    with_zz = np.insert(stresses, 2, 100.0, axis=1)
    np.testing.assert_array_equal(overlays.principal_stresses(with_zz)[0], principal)


def test_arrows_and_crosses_share_a_picture_with_its_keys(pressed_log: Any) -> None:
    scene_data = load_scene(pressed_log)
    plane = load_plane(pressed_log, scene_data, [DURATION], colour="speed", show=["velocity", "stress"])
    assert plane is not None and not plane.is_pale
    [note] = displacement_notes(plane)
    assert note == f"displacements \u00d7 {plane.scales.exaggeration:,g}".replace(",", "\u2009")
    figure = draw_plane(plane)
    texts = [one.get_text() for part in figure.subfigs for one in part.findobj(lambda one: hasattr(one, "get_text"))]
    assert note in texts and any(one.startswith("velocity \u2265 ") for one in texts)
    assert any(one.startswith("tension \u2265 ") for one in texts) and any(one.endswith(" mm") for one in texts)
    arrows, crosses = figure.axes[0].collections[-2:]
    [velocity, stress] = plane.overlays
    assert arrows.N == np.count_nonzero(np.hypot(*velocity.values[-1].T) > 0.03 * velocity.limit) > 10
    principal = overlays.principal_stresses(stress.values[-1])[0]
    assert len(crosses.get_paths()) == np.count_nonzero(np.abs(principal) > 0.03 * stress.limit) > 10


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("film.mov", {}, r"ends in \.mp4 or \.gif"),
        ("film.gif", {"size": (101, 100)}, "two even numbers"),
        ("film.gif", {"duration": 0.0}, "more than 0"),
        ("film.gif", {"frame_rate": float("nan")}, "finite"),
        ("film.gif", {"duration": 1e9}, "at most 100000 pictures"),
        ("film.gif", {"exaggerate": -1.0}, "more than 0"),
        ("film.gif", {"colour": "nothing"}, "can be coloured by"),
        ("film.gif", {"show": ["speed"]}, "this log can show displacement, velocity, stress, link_force"),
    ],
)
def test_wrong_arguments_are_reported_before_anything_is_written(
    pressed_log: Any, tmp_path: Path, name: str, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(ParameterError, match=words):
        ge.viewing.video(pressed_log, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_log_without_bodies_and_an_interrupted_film_leave_no_file(pressed_log: Any, tmp_path: Path) -> None:
    oscillator = ge.make("oscillator")
    with ge.record(oscillator, tmp_path / "oscillator.mcap"):
        oscillator.step(0.1)
    with ge.open_log(tmp_path / "oscillator.mcap") as log, pytest.raises(ParameterError, match="no body to draw"):
        ge.viewing.video(log, tmp_path / "film.gif")

    def interrupt(done: float) -> None:
        if done > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ge.viewing.video(pressed_log, tmp_path / "film.gif", duration=1.0, size=(160, 120), progress=interrupt)
    assert [one.name for one in tmp_path.iterdir()] == ["oscillator.mcap"]


def test_a_full_disk_is_one_error(pressed_log: Any, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="the extra `video` is not installed")
    view = f"view {pressed_log.path} --video {tmp_path / 'film.mp4'} --duration 1 --size 320 240"
    limited = f"ulimit -f 2; exec {sys.executable} -m granular_env {view}"  # no file above 2 kB
    done = subprocess.run(["bash", "-c", limited], capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "the encoder failed" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_missing_encoder_and_options_without_a_film_are_reported(pressed_log: Any, tmp_path: Path) -> None:
    view = [sys.executable, "-c", "import sys; sys.modules['imageio_ffmpeg'] = None; import granular_env.__main__", "view"]
    for arguments, words in (
        (["--video", str(tmp_path / "film.mp4")], "pip install 'granular-env[video]'"),
        (["--duration", "3"], "--duration: does not apply to the viewer; it applies to --video"),
        (["--video", str(tmp_path / "film.gif"), "--size", "big"], "requires 2 arguments"),
        (["--video", str(tmp_path / "film.gif"), "--exaggerate", "0"], "--exaggerate: got 0, expected more than 0"),
        (["--foxglove-layout", str(tmp_path / "layout.json"), "--colour", "speed"], "--colour: does not apply"),
    ):
        done = subprocess.run([*view, str(pressed_log.path), *arguments], capture_output=True, text=True)
        assert done.returncode == 2 and words in done.stderr and "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_map_shows_the_variable_as_crosses_arrows_or_force_chains(pressed_log: Any) -> None:
    for name, kind in (("stress", "cross"), ("velocity", "arrow"), ("link_force", "link")):
        figure = ge.viewing.plot(pressed_log, name, at=DURATION)
        plane = load_plane(pressed_log, load_scene(pressed_log), [DURATION], show=[name])
        assert plane is not None and plane.overlays[0].kind == kind
        words = {one.get_text() for part in figure.subfigs for one in part.findobj(lambda one: hasattr(one, "get_text"))}
        assert plane.overlays[0].key()[0][1] in words
    figure = ge.viewing.plot(pressed_log, "speed", "map", at=DURATION, show=["link_force"])
    assert figure.axes[-1].get_xlabel().startswith("speed [")
    with pytest.raises(ParameterError, match="does not apply to histories"):
        ge.viewing.plot(pressed_log, "speed", "histories", show=["link_force"])
