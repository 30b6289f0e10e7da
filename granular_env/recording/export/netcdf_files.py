"""NetCDF-4 files, which are HDF5 files: xarray writes their structure, and h5netcdf appends the frames."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ...optional_packages import import_optional
from ...terminal_text import printable_text
from ..dataset import assemble_dataset
from .frames import Frames

# Size of a chunk of a variable in the file, along time [bytes].
_CHUNK_BYTES = 1 << 18


def write_netcdf(frames: Frames, path: Path) -> None:
    """Write the coordinates, units and attributes of `Log.to_xarray`, and the frames, compressed without loss."""
    h5netcdf, xarray = import_optional("h5netcdf", "export to NetCDF"), import_optional("xarray", "export to NetCDF")
    dataset = assemble_dataset(frames.log, frames.names, np.zeros(0), {})
    names = {name: printable_text(name).replace("/", "_") for name in (*dataset.variables, *dataset.dims)}
    dataset = dataset.rename({old: new for old, new in names.items() if old != new})
    for variable in dataset.variables.values():
        if variable.dims[:1] == ("time",):
            extents = tuple(max(size, 1) for size in variable.shape[1:])
            chunk = max(1, min(1024, _CHUNK_BYTES // (8 * prod(extents))))
            variable.encoding = {
                "chunksizes": (chunk, *extents),
                "zlib": True,
                "complevel": 1,
                "shuffle": True,
                "_FillValue": None,
            }
    with _SteadyFile(path, "w+b") as steady:
        with h5netcdf.File(steady, "w") as file:
            dataset.dump_to_store(xarray.backends.H5NetCDFStore(file), unlimited_dims=["time"])
            for times, values in frames:
                begin = file.dimensions["time"].size
                file.resize_dimension("time", begin + len(times))
                for name, own in {"time": times, **values}.items():
                    file.variables[names[name]][begin:] = own
                if steady.failure is not None:
                    break
        if steady.failure is not None:
            raise steady.failure


class _SteadyFile(io.FileIO):
    """A file for HDF5 that keeps the first error of a write, such as a full disk, instead of raising it.

    HDF5 cannot close a file after a failed write, and ends the process with a segmentation fault.
    """

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write all of `data` unless a write has failed."""
        view, begin = memoryview(data).cast("B"), 0
        with self._keep_failure():
            while self.failure is None and begin < len(view):
                begin += super().write(view[begin:])
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size of the file unless a write has failed."""
        with self._keep_failure():
            return super().truncate(size) if self.failure is None else 0
        return 0

    @contextmanager
    def _keep_failure(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.failure = error
