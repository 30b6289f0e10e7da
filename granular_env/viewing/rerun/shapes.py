"""Links, rotations and cells in a rerun scene: lines and cracks in front of the particles, meshes with edges."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.preview.visible_drawables import area_vectors

from ..cracks import MOST_LINES, corner_pieces, crack_lines
from ..scene_data import MeshFrames, Motion

# Radii of lines, relative to the smallest particle radius; distance of lines in front of the particles' centres, over the
# largest radius. Lines are moved along the ray to the camera, so that their place in the picture does not change.
_THICKNESS, _CRACK_THICKNESS, _SPOKE_THICKNESS, _IN_FRONT = 0.05, 0.2, 0.05, 1.05
# The crack colour is visible on the dark and light backgrounds and on every colour of particles; intact links are dim.
_CRACK, _LINK, _SPOKE = (190, 0, 255), (70, 76, 84), (90, 95, 100)
_SPOKE_LENGTH = 0.9
# With more cells than these, in total or along the longest side, only the edges on the mesh's boundary are drawn.
_MOST_EDGED_CELLS, _MOST_ALONG = 2000, 200.0
# Distance of the edges in front of the cells, relative to the mesh's length.
_EDGES_IN_FRONT = 2e-3
_EDGE = (120, 124, 128)
# Brightness of the pieces of broken cells.
_BROKEN = 0.45
# Colour of the inside of a body in space, and its distance below the surface, relative to the mesh's length.
_INSIDE, _LINING = (45, 48, 52, 255), 2e-3


def entity_path(place: str, name: str) -> str:
    """Return the entity path of a name, which may contain spaces and slashes, after a prefix such as "scene/links_"."""
    return place + rr.escape_entity_path_part(name)


def send_links(recording: Any, motion: Motion, positions: npt.NDArray[Any], eye: FloatArray, when: list[Any]) -> None:
    """Send the cracks of the frames and, unless they would hide the particles, the intact links.

    The drawn positions have the shape (frames, n, 3) [m]; `eye` is the position of the camera [m].
    """
    towards = _camera_direction(motion)
    front = _move_to_front(motion, positions, eye)
    smallest = float(motion.radius.min())
    for links in motion.links:
        cracks = [
            crack_lines(places, motion.reference, links.pairs, state, towards)
            for places, state in zip(front, links.state, strict=True)
        ]
        _send_lines(recording, entity_path("scene/cracks_", links.name), cracks, _CRACK, _CRACK_THICKNESS * smallest, when)
        if len(links.pairs) > MOST_LINES:
            continue
        intact = [places[links.pairs[state != 0.0]] for places, state in zip(front, links.state, strict=True)]
        _send_lines(recording, entity_path("scene/links_", links.name), intact, _LINK, _THICKNESS * smallest, when)


def send_spokes(recording: Any, motion: Motion, positions: npt.NDArray[Any], eye: FloatArray, when: list[Any]) -> None:
    """Send a radial line (spoke) in each particle, which shows its rotation; arguments as for `send_links`."""
    if motion.rotation is None or not motion.is_plane:
        return
    front, angle = _move_to_front(motion, positions, eye), motion.rotation
    along = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    ends = front + _SPOKE_LENGTH * motion.radius[:, None] * along
    spokes = list(np.stack([front, ends], axis=2).astype(np.float32))
    thickness = _SPOKE_THICKNESS * float(motion.radius.min())
    _send_lines(recording, entity_path("scene/spokes_", motion.name), spokes, _SPOKE, thickness, when)


def _camera_direction(motion: Motion) -> npt.NDArray[np.float64]:
    """Return the direction towards the camera, which sees a plane from above and a row along +y."""
    return np.array([0.0, 0.0, 1.0] if motion.is_plane else [0.0, -1.0, 0.0])


def _move_to_front(motion: Motion, positions: npt.NDArray[Any], eye: FloatArray) -> npt.NDArray[np.float32]:
    """Return positions moved towards the eye, so that lines there lie in front of all particles."""
    ray = eye - positions
    part = _IN_FRONT * float(motion.radius.max()) / (ray @ _camera_direction(motion))
    return (positions + part[..., None] * ray).astype(np.float32)


def _send_lines(
    recording: Any, path: str, frames: list[npt.NDArray[Any]], colour: tuple[int, int, int], radius: float, when: list[Any]
) -> None:
    """Send lines of one colour; each entry of `frames` holds the lines of a frame, shape (lines, 2, 3) [m]."""
    strips = np.concatenate(frames).astype(np.float32)
    colours = np.broadcast_to(np.array(colour, np.uint8), (len(strips), 3))
    lines = rr.LineStrips3D.columns(strips=strips, colors=colours, radii=np.full(len(strips), radius, np.float32))
    recording.send_columns(path, when, lines.partition([len(one) for one in frames]))


def cells_path(mesh: MeshFrames) -> str:
    """Return the entity path of a mesh's triangles."""
    return entity_path("scene/cells_", mesh.name)


def make_triangles(connectivity: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the triangles of cells, as fans around the first corner of each cell, shape (m (k - 2), 3)."""
    first, second, third = connectivity[:, :1], connectivity[:, 1:-1], connectivity[:, 2:]
    fans = np.stack([np.broadcast_to(first, second.shape), second, third], axis=2)
    return fans.reshape(-1, 3)


def make_edges(connectivity: npt.NDArray[np.int64], nodes: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Return the edges to draw, shape (edges, 2): each edge once or, for many cells, only the boundary edges."""
    ends = np.sort(np.stack([connectivity, np.roll(connectivity, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    # Encode both ends in one number, which sorts ten times as fast as pairs.
    keys, counts = np.unique(ends[:, 0] * len(nodes) + ends[:, 1], return_counts=True)
    edges = np.stack(np.divmod(keys, len(nodes)), axis=1)
    if not len(edges):
        return edges
    along = nodes[edges[:, 1]] - nodes[edges[:, 0]]
    least = float(np.quantile(np.sqrt((along * along).sum(axis=1)), 0.1))
    is_coarse = len(connectivity) <= _MOST_EDGED_CELLS and float(np.ptp(nodes, axis=0).max()) <= _MOST_ALONG * least
    return edges if is_coarse else edges[counts == 1]


def send_triangles(recording: Any, mesh: MeshFrames) -> None:
    """Send the triangles' connectivity, which is static unless cells break."""
    if mesh.whole is None:
        triangles = rr.Mesh3D.from_fields(triangle_indices=make_triangles(_drawn_corners(mesh)).astype(np.uint32))
        recording.log(cells_path(mesh), triangles, static=True)
    if mesh.is_solid:
        normals = _node_normals(mesh)
        shading = rr.Mesh3D.from_fields(vertex_normals=normals[mesh.connectivity.ravel()] if mesh.has_cell_values else normals)
        recording.log(cells_path(mesh), shading, static=True)
        inside = rr.Mesh3D.from_fields(albedo_factor=_INSIDE)
        recording.log(_inner_surface_path(mesh), inside, static=True)


def send_mesh(
    recording: Any, mesh: MeshFrames, positions: npt.NDArray[Any], colours: npt.NDArray[np.uint8], when: list[Any]
) -> None:
    """Send frames of a mesh: drawn positions of the nodes, shape (frames, n, 3) [m], colours of nodes or cells, times."""
    corners = positions
    if mesh.whole is not None:
        _send_pieces(recording, mesh, positions, colours, when)
    if mesh.has_cell_values:
        corners = positions[:, mesh.connectivity.ravel()]
        colours = np.repeat(colours, mesh.connectivity.shape[1], axis=1)
    shown = rr.Mesh3D.columns(vertex_positions=corners.reshape(-1, 3), vertex_colors=colours.reshape(-1, 3))
    recording.send_columns(cells_path(mesh), when, shown.partition(np.full(len(corners), corners.shape[1])))
    if mesh.whole is not None:
        corners = _drawn_corners(mesh)
        _send_triangles(recording, cells_path(mesh), [corners[whole] for whole in mesh.whole], when)
    _send_edges(recording, mesh, positions, when)
    if mesh.is_solid:
        _send_lining(recording, mesh, positions, when)


def _send_pieces(
    recording: Any, mesh: MeshFrames, positions: npt.NDArray[Any], colours: npt.NDArray[np.uint8], when: list[Any]
) -> None:
    """Send the broken cells as dark pieces that move with their corners; arguments as for `send_mesh`."""
    assert mesh.whole is not None
    pieces, shades, broken = [], [], ~mesh.whole
    for places, own, cells in zip(positions, colours, broken, strict=True):
        corners = mesh.connectivity[cells]
        pieces.append(corner_pieces(mesh.nodes, places - mesh.nodes, corners))
        by_corner = np.repeat(own[cells], corners.shape[1], axis=0) if mesh.has_cell_values else own[corners.ravel()]
        shades.append(np.repeat((_BROKEN * by_corner).astype(np.uint8), 4, axis=0))
    path = entity_path("scene/broken_", mesh.name)
    vertices = np.concatenate(pieces).reshape(-1, 3).astype(np.float32)
    shown = rr.Mesh3D.columns(vertex_positions=vertices, vertex_colors=np.concatenate(shades))
    recording.send_columns(path, when, shown.partition([4 * len(one) for one in pieces]))
    _send_triangles(recording, path, [np.arange(4 * len(one)).reshape(-1, 4) for one in pieces], when)


def _send_lining(recording: Any, mesh: MeshFrames, drawn: npt.NDArray[Any], when: list[Any]) -> None:
    """Send a dark copy of a body's surface just below it, so that gaps (broken cells) do not show the far side's colours."""
    lining = (drawn - _LINING * float(np.ptp(mesh.nodes, axis=0).max()) * _node_normals(mesh)).astype(np.float32)
    path = _inner_surface_path(mesh)
    positions = rr.Mesh3D.columns(vertex_positions=lining.reshape(-1, 3))
    recording.send_columns(path, when, positions.partition(np.full(len(drawn), lining.shape[1])))
    cells = [mesh.connectivity] * len(drawn) if mesh.whole is None else [mesh.connectivity[whole] for whole in mesh.whole]
    _send_triangles(recording, path, cells, when)


def _send_triangles(recording: Any, path: str, cells: list[npt.NDArray[np.int64]], when: list[Any]) -> None:
    """Send the triangles of the cells in each frame; each entry of `cells` has the shape (m, k)."""
    triangles = [make_triangles(corners) for corners in cells]
    shown = rr.Mesh3D.columns(triangle_indices=np.concatenate(triangles).astype(np.uint32))
    recording.send_columns(path, when, shown.partition([len(one) for one in triangles]))


def _inner_surface_path(mesh: MeshFrames) -> str:
    return entity_path("scene/inside_", mesh.name)


def _node_normals(mesh: MeshFrames) -> npt.NDArray[np.float32]:
    """Return the outward normals at the nodes in the initial state, shape (n, 3)."""
    across = area_vectors(mesh.nodes[mesh.connectivity])
    sums = np.zeros_like(mesh.nodes)
    for place in range(mesh.connectivity.shape[1]):
        np.add.at(sums, mesh.connectivity[:, place], across)
    length = np.maximum(np.sqrt((sums * sums).sum(axis=1, keepdims=True)), 1e-300)
    return (sums / length).astype(np.float32)


def _send_edges(recording: Any, mesh: MeshFrames, positions: npt.NDArray[Any], when: list[Any]) -> None:
    """Send the edges of the unbroken cells; for cells in a plane, slightly in front of them so that they stay visible."""
    whole = np.ones((1, len(mesh.connectivity)), bool) if mesh.whole is None else mesh.whole
    edges = [make_edges(mesh.connectivity[kept], mesh.nodes) for kept in whole] * (len(positions) if mesh.whole is None else 1)
    strips = np.concatenate([places[ends] for places, ends in zip(positions, edges, strict=True)])
    if not mesh.is_solid:
        strips[..., 2] += _EDGES_IN_FRONT * float(np.ptp(mesh.nodes, axis=0).max())
    colour = np.broadcast_to(np.array(_EDGE, np.uint8), (len(strips), 3))
    radii = np.full(len(strips), rr.Radius.ui_points(0.5), np.float32)
    lines = rr.LineStrips3D.columns(strips=strips, colors=colour, radii=radii)
    recording.send_columns(entity_path("scene/edges_", mesh.name), when, lines.partition([len(ends) for ends in edges]))


def _drawn_corners(mesh: MeshFrames) -> npt.NDArray[np.int64]:
    """Return each cell's corners as indices of the vertices sent; cells share vertices unless colours are per cell."""
    if mesh.has_cell_values:
        return np.arange(mesh.connectivity.size).reshape(mesh.connectivity.shape)
    return mesh.connectivity
