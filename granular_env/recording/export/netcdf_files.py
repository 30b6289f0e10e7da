"""NetCDF-4 files, which are HDF5 files: xarray writes their structure, and h5netcdf appends the frames."""

from __future__ import annotations

import io
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ...optional_packages import import_optional
from ...terminal_text import printable_text
from ..dataset import assemble_dataset
from .frames import Frames

# Size of the frames that are written together [bytes].
_BLOCK = 1 << 22


def write_netcdf(frames: Frames, path: Path) -> None:
    """Write the coordinates, units and attributes of `Log.to_xarray`, and the frames, compressed without loss."""
    h5netcdf, xarray = import_optional("h5netcdf", "export to NetCDF"), import_optional("xarray", "export to NetCDF")
    variables = {name: frames.log.variables[name] for name in frames.names}
    dataset = assemble_dataset(frames.log, np.zeros(0), {name: np.zeros((0, *one.shape)) for name, one in variables.items()})
    names = {name: printable_text(name).replace("/", "_") for name in (*dataset.variables, *dataset.dims)}
    dataset = dataset.rename(names)
    for name in variables:
        dataset[names[name]].encoding = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}
    count = max(1, _BLOCK // (8 + 8 * sum(prod(one.shape) for one in variables.values())))
    with _SteadyFile(path, "w+b") as steady:
        with h5netcdf.File(steady, "w") as file:
            dataset.dump_to_store(xarray.backends.H5NetCDFStore(file), unlimited_dims=["time"])
            rest = iter(frames)
            while (block := list(islice(rest, count))) and steady.failure is None:
                begin = file.dimensions["time"].size
                file.resize_dimension("time", begin + len(block))
                file.variables["time"][begin:] = [time for time, _ in block]
                for name in variables:
                    file.variables[names[name]][begin:] = np.stack([frame[name] for _, frame in block])
        if steady.failure is not None:
            raise steady.failure


class _SteadyFile(io.FileIO):
    """A file for HDF5 that keeps the first error of a write, such as a full disk, instead of raising it.

    HDF5 cannot close a file after a failed write, and ends the process with a segmentation fault.
    """

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write all of `data`."""
        view, begin = memoryview(data).cast("B"), 0
        try:
            while begin < len(view):
                begin += super().write(view[begin:])
        except OSError as error:
            self.failure = self.failure or error
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size of the file."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.failure = self.failure or error
            return 0
