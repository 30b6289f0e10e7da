"""Paths of entities with names that authors chose: rerun reads spaces and slashes in them as more than letters."""

from __future__ import annotations

from granular_env.optional_packages import import_optional


def entity(place: str, name: str) -> str:
    """Return the path of a name below a place, such as "scene/links_" and "surface links"."""
    return place + import_optional("rerun", "the viewer").escape_entity_path_part(name)
