"""Arrays of real numbers given by users: finite numbers; no text, truth values or masked arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .errors import Location, ParameterError, one_line, to_location
from .support.float_arrays import FloatArray
from .support.validation import finite_number
from .variables import check_index, index_text, parse_index

Shape = tuple[int, ...]
_NUMBERS = (int, float, np.integer, np.floating)


def number_array(at: str | Location, value: Any, expected: str, shapes: Sequence[Shape] | None = None) -> FloatArray:
    """Return a new float64 array with the given numbers.

    Args:
        at: location of the value, for messages.
        value: an array, or lists in lists.
        expected: description of a valid value.
        shapes: accepted shapes; None for any.

    Raises:
        ParameterError: it holds non-finite or non-numeric values, rows of different length, or it has another shape.
    """
    if value.__class__ is np.ndarray and value.dtype == np.float64:
        array = value.copy(order="C")
    else:
        array = _convert_numbers(at, value, expected)
    if shapes is not None and array.shape not in shapes:
        came = "a single number" if array.shape == () else f"an array of shape {array.shape}"
        raise ParameterError(f"got {came}", expected=expected, at=at)
    if not np.isfinite(array).all():
        place = tuple(int(index) for index in np.argwhere(~np.isfinite(array))[0])
        raise ParameterError(f"got {array[place]:g}", expected="a finite number", at=(*to_location(at), *place))
    return array


def _convert_numbers(at: str | Location, value: Any, expected: str) -> FloatArray:
    if isinstance(value, np.ma.MaskedArray):
        hint = "fill the masked elements: array.filled(value)"
        raise ParameterError(f"got {one_line(value)}", expected=expected, hint=hint, at=at)
    try:
        given = np.asarray(value)
        if isinstance(value, list | tuple):  # numpy would convert truth values in lists, but not large integers
            parts = np.asarray(value, dtype=object)
            numbers = all(isinstance(one, _NUMBERS) and not isinstance(one, bool) for one in parts.flat)
        else:
            numbers = given.dtype.kind in "fiu"
        if numbers:
            with np.errstate(all="ignore"):  # wider numbers that overflow become infinite and are refused
                return np.array(given, dtype=np.float64, order="C")
    except (ValueError, OverflowError, TypeError):
        if isinstance(value, list | tuple) and any(isinstance(row, list | tuple | np.ndarray) for row in value):
            raise ParameterError("got rows of different length", expected=expected, at=at) from None
    raise ParameterError(f"got {one_line(value)}", expected=expected, at=at)


def start_array(at: str | Location, value: Any, shape: Shape, default: FloatArray | float = 0.0) -> FloatArray:
    """Return an array of `shape` from one number, one row, an array, or {index: value or row} with `default` elsewhere.

    A row is the sub-array at one index of the first axis, e.g. two numbers for shape (n, 2). {"3,1": value} and
    {(3, 1): value} set a single element.

    Raises:
        ParameterError: it is none of these, or not finite, or it sets an element twice.
    """
    array, at = np.zeros(shape), to_location(at)
    array[...] = default
    if not isinstance(value, Mapping):
        array[...] = _broadcast_numbers(at, value, shape, "{index: value}")
        return array
    if not shape:
        raise ParameterError("got {index: value}", expected="a single number", at=at)
    given = np.zeros(shape, dtype=bool)
    for key, item in value.items():
        index = _parse_row_index(at, key, shape)
        if given[index].any():
            raise ParameterError(f"got {index_text(index)} twice", expected="each element once", at=at)
        given[index] = True
        array[index] = _broadcast_numbers((*at, *index), item, shape[len(index) :])
    return array


def _broadcast_numbers(at: Location, value: Any, shape: Shape, *others: str) -> FloatArray | float:
    """Return finite numbers that broadcast to an array of the given shape: one number, a row, or all of them."""
    if not shape:
        return finite_number(at, value)
    # A row for all is accepted only for several axes: for shape (n,) a row is a number.
    shapes = [shape[1:], shape] if len(shape) > 1 else [shape]
    *forms, last = ["a number", *(f"an array of shape {one}" for one in shapes), *others]
    return number_array(at, value, f"{', '.join(forms)} or {last}", ((), *shapes))


def _parse_row_index(at: Location, key: Any, shape: Shape) -> Shape:
    """Return the index of a row or of an element, counted from 0."""
    try:
        index = parse_index(key)
        # One number is the index of a row; several numbers must be the index of an element.
        check_index(at, index, shape[:1] if len(index) == 1 else shape)
    except ParameterError as error:
        raise error.with_outer_location(*at) from None
    return tuple(number % size for number, size in zip(index, shape, strict=False))
