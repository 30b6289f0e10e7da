"""Logs of every system exported to every format and read by pandas, xarray, h5py, VTK and ASE: the values agree bit for bit."""

from __future__ import annotations

import errno
import json
import os
import re
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from support.automata_tools import block
from support.recording_helpers import chain_log, rewrite_log

import granular_env as ge
from granular_env.cli.program import main
from granular_env.components.drawables import Cells, Links, Points, to_three_columns
from granular_env.components.errors import LogError, MissingExtraError, ParameterError
from granular_env.components.variables import Element
from granular_env.recording.index import CHUNK
from granular_env.recording.records import HEADER, Record

GOLDEN = Path(__file__).resolve().parent.parent / "logs" / "golden"
# One log of every system.
SYSTEMS = (
    "piston", "discs", "grid-edges", "automata-cracking",
    "coupled-cracking", "shell-cracking", "detonation-nozzle", "tube-burning",
)  # fmt: skip
FORMATS = ("vtk", "xyz", "csv", "netcdf", "hdf5")


def bits(values: Any) -> bytes:
    """Return the bits of values, in the same order for every memory layout."""
    return np.ascontiguousarray(values, dtype=np.float64).tobytes()


def three_columns(values: np.ndarray) -> np.ndarray:
    """Return an array of elements as the geometric formats store it: vectors in a plane have a third component 0."""
    rows = values.reshape(len(values), -1)
    return to_three_columns(rows) if rows.shape[1] == 2 else rows


@pytest.fixture(params=SYSTEMS)
def log(request):
    with ge.open_log(GOLDEN / f"{request.param}.mcap") as log:
        yield log


# -- formats --------------------------------------------------------------------------------------------------------


def test_csv_has_the_bits_of_every_number(log, tmp_path):
    pandas = pytest.importorskip("pandas")
    log.export("csv", tmp_path / "a.csv", variables=list(log.variables))
    table = pandas.read_csv(tmp_path / "a.csv")
    columns = 1
    assert bits(table["time [s]"]) == bits(log.times(next(iter(log.variables))))
    for name, variable in log.variables.items():
        values = log.series(name)[1].reshape(len(table), -1)
        own = table.iloc[:, columns : columns + values.shape[1]]
        assert bits(own) == bits(values)
        unit = "" if variable.unit == "1" else f" [{variable.unit}]"
        assert list(own.columns) == [f"{Element(name, index)}{unit}" for index in np.ndindex(variable.shape)]
        columns += values.shape[1]
    assert columns == table.shape[1]


def test_csv_contains_histories_unless_variables_are_requested(tmp_path):
    ge.open_log(GOLDEN / "discs.mcap").export("csv", tmp_path / "a.csv", variables=["momentum", "speed"])
    assert (tmp_path / "a.csv").read_text().startswith("time [s],speed[0] [m/s],speed[1] [m/s]")
    done = ge.open_log(GOLDEN / "grid-edges.mcap").export("csv", tmp_path / "b.csv")
    assert "kinetic_energy" in done.variables and not {"displacement", "stress"} & set(done.variables)


def test_netcdf_equals_the_dataset_of_the_log(log, tmp_path):
    xarray = pytest.importorskip("xarray")
    log.export("netcdf", tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as found:
        expected = log.to_xarray()
        xarray.testing.assert_identical(found.load(), expected)
    for own in log.variables:
        assert bits(found[own]) == bits(log.series(own)[1]) and found[own].attrs["units"] == log.variables[own].unit


def test_hdf5_is_readable_by_h5py_alone(tmp_path):
    h5py = pytest.importorskip("h5py")
    log = ge.open_log(GOLDEN / "coupled-cracking.mcap")
    log.export("hdf5", tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        assert bits(file["grid_stress"]) == bits(log.series("grid_stress")[1])
        assert bits(file["node_x"]) == bits(log.drawables[0].nodes[:, 0])
        assert file["cell_nodes"][:].tolist() == log.drawables[0].connectivity.tolist()
        assert [one.decode() for one in file["entry"]] == ["xx", "yy", "zz", "xy"]
        assert json.loads(file.attrs["parameters"]) == log.metadata["parameters"]


def test_the_dataset_shares_directions_and_has_positions():
    pytest.importorskip("xarray")
    data = ge.open_log(GOLDEN / "shell-cracking.mcap").to_xarray()
    assert data.momentum.dims == data.wall_impulse.dims == ("time", "direction")
    assert data.direction.values.tolist() == ["x", "y", "z"]
    assert {"node_x", "node_radius", "cell_nodes", "surface_node_z", "link_points"} <= set(data.coords)
    gas = ge.open_log(GOLDEN / "detonation-nozzle.mcap")
    assert bits(gas.to_xarray().cell_x) == bits(gas.drawables[0].nodes[gas.drawables[0].connectivity].mean(axis=1)[:, 0])


def read_vtk(path: Path) -> Any:
    """Return the grid in a `.vtu` file."""
    vtk = pytest.importorskip("vtk")
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def vtk_arrays(data: Any) -> dict[str, np.ndarray]:
    """Return the arrays of points or cells by name."""
    numpy_support = pytest.importorskip("vtk.util.numpy_support")
    arrays = [data.GetArray(place) for place in range(data.GetNumberOfArrays())]
    return {one.GetName(): numpy_support.vtk_to_numpy(one) for one in arrays}


@pytest.mark.extra
def test_vtk_reads_frames_times_and_warped_positions(log, tmp_path):
    vtk = pytest.importorskip("vtk")
    done = log.export("vtk", tmp_path / "a")
    names = [re.sub(r"[^A-Za-z0-9._-]+", "-", one.name) for one in log.drawables]
    found = set()
    for name, drawable in zip(names, log.drawables, strict=True):
        if not (tmp_path / "a" / f"{name}.pvd").exists():
            continue  # a curve
        entries = ElementTree.parse(tmp_path / "a" / f"{name}.pvd").getroot().iter("DataSet")
        files = [(float(one.attrib["timestep"]), tmp_path / "a" / one.attrib["file"]) for one in entries]
        assert [time for time, _ in files] == log.times(done.variables[0]).tolist()
        for frame in (0, len(files) - 1):
            grid = read_vtk(files[frame][1])
            arrays = {**vtk_arrays(grid.GetPointData()), **vtk_arrays(grid.GetCellData())}
            for label, values in arrays.items():
                own = label.partition(" [")[0]
                if own == "radius" or (isinstance(drawable, Links) and "displacement" in own):
                    continue
                series = log.series(own)[1][frame]
                is_moved = own == drawable_displacement(drawable)
                assert label == (f"{own} [{log.variables[own].unit}]" if log.variables[own].unit != "1" else own)
                assert bits(values) == bits(to_three_columns(series) if is_moved else three_columns(series))
                found.add(own)
            if (own := drawable_displacement(drawable)) in log.variables:
                warp = vtk.vtkWarpVector()
                warp.SetInputData(grid)
                warp.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, f"{own} [m]")
                warp.Update()
                moved = warp.GetOutput().GetPoints().GetData()
                reference = drawable.nodes if isinstance(drawable, Cells) else drawable.reference
                expected = to_three_columns(reference) + to_three_columns(log.series(own)[1][frame])
                assert bits(pytest.importorskip("vtk.util.numpy_support").vtk_to_numpy(moved)) == bits(expected)
    assert found >= set(done.variables)


def drawable_displacement(drawable: Any) -> str:
    """Return the displacement of points or cells; empty for others."""
    return getattr(drawable, "displacement", "")


@pytest.mark.extra
def test_vtk_has_cells_links_and_events(tmp_path):
    gas, automata = ge.open_log(GOLDEN / "detonation-nozzle.mcap"), ge.open_log(GOLDEN / "automata-cracking.mcap")
    gas.export("vtk", tmp_path / "gas")
    tube = read_vtk(tmp_path / "gas" / "tube" / "000004.vtu")
    assert bits(vtk_arrays(tube.GetCellData())["temperature [K]"]) == bits(gas.series("temperature")[1][4])

    automata.export("vtk", tmp_path / "automata")
    points, links = automata.drawables
    assert isinstance(points, Points) and isinstance(links, Links)
    first = read_vtk(tmp_path / "automata" / "links" / "000006.vtu")
    assert first.GetNumberOfCells() == len(links.pairs) and first.GetPoint(1)[:2] == tuple(points.reference[links.pairs[0, 1]])
    assert bits(vtk_arrays(first.GetCellData())["linked"]) == bits(automata.series("linked")[1][6])
    moved = vtk_arrays(first.GetPointData())["displacement [m]"][:, :2].reshape(-1, 2, 2)
    assert bits(moved) == bits(automata.series("displacement")[1][6][links.pairs])

    events = automata.events("drucker_prager_break")
    broken = vtk_arrays(read_vtk(tmp_path / "automata" / "events-drucker_prager_break.vtu").GetPointData())
    assert bits(broken["time [s]"]) == bits([one.tick * automata.step_size for one in events])
    assert bits(broken["value [Pa]"]) == bits([one.value for one in events])


@pytest.mark.extra
def test_ase_reads_extended_xyz(log, tmp_path):
    reader = pytest.importorskip("ase.io")
    sets = [one for one in log.drawables if isinstance(one, Points)]
    if not sets:
        with pytest.raises(LogError, match="no recorded variable that the format xyz contains"):
            log.export("xyz", tmp_path / "a.xyz")
        return
    done = log.export("xyz", tmp_path / "a")
    points = sets[-1] if log.header["component"] == "coupled" else sets[0]  # automata rather than the nodes of cells
    frames = reader.read(done.path, ":", format="extxyz")
    assert [one.info["Time"] for one in frames] == log.times(done.variables[0]).tolist()
    moved = log.series(points.displacement)[1]
    for place, frame in enumerate(frames):
        expected = to_three_columns(points.reference) + to_three_columns(moved[place])
        assert bits(frame.positions) == bits(expected) and bits(frame.arrays["radius"]) == bits(points.radius)
        assert set(done.variables) <= frame.arrays.keys()
        for name in done.variables:
            own = frame.arrays[name].reshape(len(points.radius), -1)
            assert bits(own) == bits(three_columns(log.series(name)[1][place]))


@pytest.mark.extra
def test_periodic_points_have_a_cell_and_links_across_the_edge(tmp_path):
    reader = pytest.importorskip("ase.io")
    body = block(columns=4, rows=3, boundaries={"left": "periodic", "right": "periodic"})
    with ge.record(body, tmp_path / "a.mcap", variables=["displacement", "linked"]):
        body.step(2 * body.step_size)
    log = ge.open_log(tmp_path / "a.mcap")
    points, links = log.drawables
    assert isinstance(points, Points) and isinstance(links, Links)
    frame = reader.read(log.export("xyz", tmp_path / "a.xyz").path, 0, format="extxyz")
    assert frame.cell[0, 0] == points.period[0] and frame.pbc.tolist() == [True, False, False]
    log.export("vtk", tmp_path / "v")
    grid = read_vtk(tmp_path / "v" / "links" / "000000.vtu")
    ends = np.array([grid.GetPoint(place) for place in range(grid.GetNumberOfPoints())]).reshape(-1, 2, 3)
    assert np.allclose(np.diff(ends, axis=1)[:, 0, :2], points.shortest_vectors(links.pairs), atol=1e-15)
    assert not points.is_unwrapped(links.pairs).all()


# -- selection ------------------------------------------------------------------------------------------------------


def test_times_and_variables_are_selected(tmp_path):
    log = ge.open_log(GOLDEN / "piston.mcap")
    times, step = log.times("velocity"), log.step_size
    for start, end, every in ((times[3], None, None), (None, times[5], None), (times[2], times[20], 3 * (times[1] - times[0]))):
        done = log.export("csv", tmp_path / "a.csv", start=start, end=end, every=every, variables=["momentum"], overwrite=True)
        found = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
        inside = times[(times >= (start or 0.0) - 0.1 * step) & (times <= (end or 1.0) + 0.1 * step)]
        assert found[:, 0].tolist() == inside[:: 3 if every else 1].tolist()
        assert done.frames == len(found) and done.variables == ("momentum",)


def test_every_is_an_interval_also_for_frames_at_uneven_times(tmp_path):
    log = ge.open_log(GOLDEN / "discs.mcap")
    times = log.times("speed")
    log.export("csv", tmp_path / "a.csv", every=0.4 * float(times[-1] - times[0]))
    kept = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)[:, 0]
    assert kept[0] == times[0] and len(kept) == 3


def test_segments_follow_each_other(tmp_path):
    oscillator = ge.make("oscillator")
    with ge.record(oscillator, tmp_path / "a.mcap", every=0.05):
        for velocity in (1.0, 2.0):
            oscillator.reset(velocity=velocity)
            oscillator.step(0.3)
    log = ge.open_log(tmp_path / "a.mcap")
    log.export("csv", tmp_path / "a.csv", variables=["position"])
    assert bits(np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)) == bits(np.transpose(log.series("position")))


# -- refusals and damage --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("log", "arguments", "said"),
    [
        ("piston", ["--to", "csv", "--variables", "velocty"], "did you mean 'velocity'"),
        ("piston", ["--to", "vtk", "--variables", "momentum"], "expected a recorded variable that the format vtk contains"),
        ("oscillator", ["--to", "vtk"], "the formats csv, netcdf and hdf5 contain every variable"),
        ("piston", ["--to", "csv", "--from", "1"], "--from: no frame was recorded in this time range, expected a part of 0 to"),
        ("piston", ["--to", "csv", "--every", "0"], "--every: got 0.0, expected a number of seconds above 0"),
        ("piston", ["--to", "csv", "--every", "3mm"], "Invalid value for '--every'"),
        ("piston", ["--to", "csv", "--out", "/dev/full"], "--out: '/dev/full' is a device, a pipe or a socket"),
        ("piston", ["--to", "csv", "--out", "piston.mcap", "--overwrite"], "--out: this file is the log"),
        ("piston", ["--to", "csv", "--out", "."], "--out: '.' is a folder"),
        ("piston", ["--to", "vtk", "--out", ".", "--overwrite"], "'.' is not a folder of exported files alone"),
        ("piston", ["--to", "csv", "--out", "a.csv/b"], "a.csv/b' cannot be written: Not a directory"),
    ],
)
def test_refusals_are_one_message_and_write_nothing(log, arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path(f"{log}.mcap").write_bytes((GOLDEN / f"{log}.mcap").read_bytes())
    Path("a.csv").write_text("kept")
    before = sorted(tmp_path.rglob("*"))
    assert main(["export", f"{log}.mcap", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before and Path("a.csv").read_text() == "kept"


@pytest.mark.parametrize("to", FORMATS)
def test_an_existing_export_is_replaced_only_on_request(to, tmp_path):
    log = ge.open_log(GOLDEN / "coupled-cracking.mcap")
    path = log.export(to, tmp_path / "a").path
    with pytest.raises(ParameterError, match="exists already; choose another name, or pass overwrite=True"):
        log.export(to, path)
    assert log.export(to, path, every=1.0, overwrite=True).frames == 1
    assert [one.name for one in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("to", FORMATS)
def test_an_interrupt_leaves_nothing(to, tmp_path):
    chain_log(tmp_path / "a.mcap")

    def interrupt(fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ge.open_log(tmp_path / "a.mcap").export(to, tmp_path / "out", progress=interrupt)
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]


@pytest.mark.parametrize("to", FORMATS)
def test_a_full_disk_is_one_message_and_leaves_nothing(to, tmp_path):
    def limit_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

    log = GOLDEN / "piston.mcap"
    command = [sys.executable, "-m", "granular_env", "export", str(log), "--to", to, "--out", str(tmp_path / "out")]
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, preexec_fn=limit_files, capture_output=True, text=True, env=environment, check=False)  # noqa: PLW1509
    assert done.returncode == 2 and "cannot be written" in done.stderr and "Traceback" not in done.stderr
    assert os.strerror(errno.EFBIG) in done.stderr and not list(tmp_path.iterdir())


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser writes everywhere")
@pytest.mark.parametrize("to", FORMATS)
def test_a_read_only_folder_is_one_message(to, tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(LogError, match="cannot be written: Permission denied"):
        ge.open_log(GOLDEN / "piston.mcap").export(to, tmp_path / "out")


def record_long_chain(path: Path) -> Path:
    chain = ge.make("chain", grains=200, step_size=1e-6)
    with ge.record(chain, path, every=chain.step_size):
        chain.reset(velocity=np.random.default_rng(0).normal(size=200))
        for _ in range(8):
            chain.step(400 * chain.step_size)
    return path


def test_intact_frames_after_a_damaged_record_are_exported(tmp_path):
    path = record_long_chain(tmp_path / "a.mcap")
    with ge.open_log(path) as log:
        times, rows = log.times("velocity"), log.frame_rows("velocity")
        offset, length = log.container.places[rows[len(rows) // 2][CHUNK]]
        assert rows[-1][CHUNK] > rows[len(rows) // 2][CHUNK] > rows[0][CHUNK]
    data = bytearray(path.read_bytes())
    data[offset + length // 2] ^= 1
    path.write_bytes(data)
    with ge.open_log(path) as log:
        done = log.export("csv", tmp_path / "a.csv", variables=["velocity", "displacement"])
    kept = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1, usecols=0)
    missing = np.setdiff1d(times, kept)
    assert 0 < len(missing) < len(times) - 2 and kept[0] == times[0] and kept[-1] == times[-1]
    assert f"frames from {missing[0]:g} s to {missing[-1]:g} s are missing" in done.missing


@pytest.mark.parametrize("to", FORMATS)
def test_the_intact_part_of_a_damaged_log_is_exported(to, tmp_path, capsys):
    record_long_chain(tmp_path / "a.mcap")
    data = bytearray((tmp_path / "a.mcap").read_bytes())
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    with ge.open_log(tmp_path / "a.mcap") as log:
        offset, length = log.container.places[log.frame_rows("kinetic_energy" if to == "csv" else "displacement")[-1][CHUNK]]
    data[offset + length // 2] ^= 1
    (tmp_path / "flipped.mcap").write_bytes(data)
    for name, said in (("cut", "the log was not closed"), ("flipped", "is damaged: the chunk at byte")):
        arguments = ["export", str(tmp_path / f"{name}.mcap"), "--to", to, "--every", "4e-4"]
        assert main([*arguments, "--out", str(tmp_path / "out"), "--overwrite", "--json"]) == 1
        shown = capsys.readouterr()
        result = json.loads(shown.out)
        assert said in shown.err and said in result["missing"] and 1 <= result["frames"] < 9
        assert Path(result["written"]).exists()


def test_names_may_contain_any_characters(tmp_path):
    xarray = pytest.importorskip("xarray")
    names = {"velocity": 'v/"<&>\n\x00;, \u00e9:', "displacement": "../\u202e\u2713"}

    def rename(record: Record) -> Record:
        if record.kind != HEADER:
            return record
        texts = json.loads(json.dumps(record.header))
        for variable in texts["variables"]:
            variable["name"] = names.get(variable["name"], variable["name"])
        texts["drawables"] = [{**one, "name": "../a b/", "displacement": names["displacement"]} for one in texts["drawables"]]
        return Record(*(getattr(record, field) for field in list(Record.__slots__)[:-2]), texts, record.arrays)

    rewrite_log(GOLDEN / "piston.mcap", tmp_path / "a.mcap", rename)
    log = ge.open_log(tmp_path / "a.mcap")
    for to in FORMATS:
        done = log.export(to, tmp_path / to, variables=list(names.values()))
        assert set(done.variables) == set(names.values())
    with xarray.open_dataset(tmp_path / "hdf5", engine="h5netcdf") as data:
        assert bits(data['v_"<&>\\n\\x00;, \u00e9:']) == bits(log.series(names["velocity"])[1])
    assert sorted(one.name for one in (tmp_path / "vtk").iterdir()) == ["a-b", "a-b.pvd"]
    ElementTree.parse(tmp_path / "vtk" / "a-b.pvd")


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    for to, module in (("vtk", "pyevtk.vtk"), ("netcdf", "h5netcdf"), ("hdf5", "h5netcdf")):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(MissingExtraError, match=r"pip install 'granular-env\[data\]'"):
            ge.open_log(GOLDEN / "piston.mcap").export(to, tmp_path / "a")
        assert not list(tmp_path.iterdir())


def test_the_command_prints_what_it_wrote(tmp_path, capsys):
    assert main(["export", str(GOLDEN / "grid-edges.mcap"), "--to", "csv", "--out", str(tmp_path / "a.csv")]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"written: {tmp_path / 'a.csv'}, 2 frames of 14 variables",
        "left out: displacement, velocity, stress, speed; request them with --variables",
    ]
