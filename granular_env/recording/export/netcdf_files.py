"""NetCDF-4 files, which are HDF5 files: xarray writes their structure, and h5py appends the frames."""

from __future__ import annotations

from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ...components.errors import LogError
from ...optional_packages import import_optional
from ...terminal_text import printable_text
from ..dataset import assemble_dataset
from .frames import Frames

# Size of a chunk of a variable in the file, along time [bytes].
_CHUNK_BYTES = 1 << 18


def write_netcdf(frames: Frames, path: Path) -> None:
    """Write the coordinates, units and attributes of `Log.to_xarray`, and the frames, compressed without loss."""
    h5py, _ = import_optional("h5py", "export to NetCDF"), import_optional("h5netcdf", "export to NetCDF")
    dataset = assemble_dataset(frames.log, frames.names, np.zeros(0), {})
    names = {name: printable_text(name).replace("/", "_") for name in (*dataset.variables, *dataset.dims)}
    dataset = dataset.rename({old: new for old, new in names.items() if old != new})
    try:
        growing = {name: _chunks(one) for name, one in dataset.variables.items() if one.dims[:1] == ("time",)}
        dataset.to_netcdf(path, engine="h5netcdf", unlimited_dims=["time"], encoding=growing)
        with h5py.File(path, "r+") as file:
            written = 0
            for block in frames:
                for name, values in {"time": block.times, **block.values}.items():
                    table = file[names[name]]
                    table.resize(written + len(values), axis=0)
                    table[written:] = values
                written += len(block.times)
    except RuntimeError as error:  # HDF5 reports a full disk on closing as this
        raise LogError(f"{str(path)!r} cannot be written: {error}") from error


def _chunks(variable: Any) -> dict[str, Any]:
    """Return xarray's encoding of a variable that grows in time."""
    shape = tuple(max(size, 1) for size in variable.shape[1:])
    frames = max(1, min(1024, _CHUNK_BYTES // (8 * prod(shape))))
    return {"chunksizes": (frames, *shape), "zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}
