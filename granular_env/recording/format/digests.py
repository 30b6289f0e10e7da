"""Digests in a log: hashes of the state and of what was held, and second accounts of parameters, header and inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.inputs import Held
from ...components.profiles import CompiledProfile
from ...components.support.serialization import canonical_json, digest
from .records import bits, words


def hash_row(component: Component, state: Iterable[str], inputs: Iterable[str]) -> np.ndarray:
    """One word for each state variable, one for the whole state, one for each input now held; int64."""
    row = [_word(digest(words(component.peek(name)))) for name in state]
    row.append(_word(digest(component.state_view())))
    held = component.held_inputs
    row += [held_word(held[name]) for name in inputs]
    return np.array(row, dtype=np.int64)


def held_word(value: Held) -> int:
    """Return the bits of a number, or a digest of those of an array or a profile."""
    if isinstance(value, CompiledProfile):
        pattern = b"" if value.pattern is None else value.pattern.tobytes()
        return _word(digest(value.ticks.tobytes() + value.coefficients.tobytes() + pattern))
    return array_word(value) if isinstance(value, np.ndarray) else bits(value)


def array_word(array: np.ndarray) -> int:
    """Return a digest of the bits of an array."""
    return _word(digest(words(array)))


def _word(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def parameter_digests(component: Component) -> dict[str, str]:
    """Return a digest of each parameter that differs from its default, so that a changed one can be named."""
    parameters = component.parameters.model_dump(mode="json", exclude_defaults=True)
    return {name: digest(canonical_json(value)).hex() for name, value in parameters.items()}


def header_digests(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Return a digest of each entry of the header, apart from the header: so a changed one can be named.

    The parameters have `parameter_digests`.
    """
    found = {name: digest(canonical_json(value)).hex() for name, value in header.items() if name != "parameters"}
    return found | {name: digest(words(array)).hex() for name, array in arrays.items()}


def step_digests(durations: np.ndarray, sets: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> dict[str, str]:
    """Digests of what a batch of steps did: under "" its lengths, under each input's name when it was set and to what.

    What it was set to is a `held_word`: a profile counts by its content.
    """
    found = {"": digest(durations.tobytes()).hex()}
    for name, (places, values) in sets.items():
        found[name] = digest(places.tobytes() + values.tobytes()).hex()
    return found


def set_words(numbers: np.ndarray, values: np.ndarray, profile_words: Mapping[int, int]) -> np.ndarray:
    """Return the `held_word` of each value that an input was set to.

    Args:
        numbers: that of the profile, or -1 where it was no profile, shape (sets,).
        values: the numbers or arrays that it was set to where it was no profile, shape (those, ...).
        profile_words: number of a profile -> its `held_word`.
    """
    found = np.empty(len(numbers), dtype=np.int64)
    plain = numbers < 0
    found[plain] = values.view(np.int64) if values.ndim == 1 else [array_word(value) for value in values]
    found[~plain] = [profile_words[number] for number in numbers[~plain].tolist()]
    return found
