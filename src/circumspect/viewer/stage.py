"""The 3D view of the dashboard: room, robot, paths, object and grid."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import PinholeCamera
from circumspect.grid import OccupancyGrid
from circumspect.runs.playback_moment import thinned
from circumspect.runs.surroundings import Surroundings
from circumspect.viewer.colouring import (
    COLOURINGS,
    EVIDENCE,
    EVIDENCE_GROUPS,
    FRAMES,
    NORMAL,
    ODOMETRY,
    PATH,
    TARGET,
    depth_picture,
    directions,
    in_groups,
    linear,
    pale,
    sequential,
    signed,
)
from circumspect.viewer.dashboard_state import DashboardState, FrameImages, ObjectSnapshot
from circumspect.viewer.occupied_cells import cell_boxes, outline, robot_boxes
from circumspect.viewer.why import Explanation

if TYPE_CHECKING:
    import viser

ROBOT = (96, 112, 140)
CELL, OUTLINE = (90, 150, 220), (130, 140, 155)
INK = (30, 41, 59)
LAYERS = {"grid": True, "paths": True, "room": True, "normals": False}
"""Layers that can be hidden, and their initial visibility."""
CHANGING = {"points", "colors", "vertices", "faces", "color", "opacity", "image"}
"""Properties of nodes that change between moments."""
MOST_VERTICES = 600
"""Maximum number of vertices of a path."""
MOST_NORMALS = 400
NORMAL_LENGTH, ARROW_LENGTH, ARROW_HEIGHT = 0.05, 0.3, 0.4
"""Length of normals, length of the arrow of the next view and its height above the floor [m]."""
WALL_OPACITY, CLUTTER_OPACITY = 0.07, 0.3
"""Opacity of surroundings, which may occlude the object."""
FIELD_OF_VIEW = np.radians(45.0)
"""Vertical field of view [rad]."""
OBJECT_SHARE = 0.7
"""Initial height of the object as a fraction of the view's height."""
BESIDE_PANEL = 0.2
"""Offset of the object to the left as a fraction of the view's height; the panel covers the right
of the view."""
SMALLEST_REACH = 0.25
"""Minimum radius of the object for the initial view [m]."""


class Stage:
    """The viser scene of a run.

    Attributes:
        colouring: Colouring of the object's points, one of `COLOURINGS`.
        yaw: Rotation of the object by the slider [rad].
        explanation: Explanation of the answer; None if there is none.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        """Start with an empty scene."""
        self._server, self._scene = server, server.scene
        self.colouring = COLOURINGS[0]
        self.yaw = 0.0
        self.explanation: Explanation | None = None
        self._nodes: dict[str, Any] = {}
        self._grid_drawn: tuple[object, ...] = ()
        self._pictured: FrameImages | None = None
        self._shown_surroundings: Surroundings | None = None
        self._lookout_set = False
        self._visible = dict(LAYERS)
        self._layers = {
            name: self._scene.add_frame(f"/{name}", show_axes=False, visible=visible)
            for name, visible in LAYERS.items()
        }
        self._scene.set_up_direction("+z")
        self._scene.configure_environment_map(None)
        self._scene.configure_default_lights(enabled=False)
        self._scene.add_light_ambient("/light/ambient", intensity=1.4)
        self._scene.add_light_directional(
            "/light/sun", intensity=1.6, wxyz=(0.86, 0.36, 0.36, 0.0), cast_shadow=False
        )
        self._scene.add_grid(
            "/floor", width=12.0, height=12.0, cell_size=0.5, section_size=1.0, plane="xy",
            cell_color=(226, 230, 236), section_color=(203, 210, 220), shadow_opacity=0.0,
        )  # fmt: skip

    def set_visible(self, layer: str, visible: bool) -> None:
        """Show or hide one of `LAYERS`."""
        self._visible[layer] = visible
        self._layers[layer].visible = visible

    def _clear(self) -> None:
        """Remove all nodes of a run."""
        self._drop_all("/")
        self._grid_drawn = ()
        self._pictured = None
        self._lookout_set = False

    def _show_surroundings(self, surroundings: Surroundings | None) -> None:
        """Show walls and clutter."""
        self._shown_surroundings = surroundings
        if surroundings is None:
            return
        for number, mesh in enumerate(surroundings.meshes):
            self._put(
                f"/room/{number}", self._scene.add_mesh_simple, position=(0.0, 0.0, 0.0),
                vertices=np.asarray(mesh.vertices_xyz, np.float32),
                faces=np.asarray(mesh.faces, np.uint32),
                color=pale(mesh.colour),
                opacity=WALL_OPACITY if mesh.wall else CLUTTER_OPACITY,
                flat_shading=True, side="double", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip

    def show(self, state: DashboardState, turned: OccupancyGrid | None = None) -> None:
        """Show a state as a single update.

        Args:
            state: The state.
            turned: Grid of the rotated object; None without rotation.
        """
        with self._server.atomic():
            # Before the first frame, all nodes belong to another run.
            if state.count == 0 or state.surroundings is not self._shown_surroundings:
                self._clear()
                self._show_surroundings(state.surroundings)
            self._show_object(state.object_snapshot)
            self._show_grid(state.object_snapshot.grid if turned is None else turned)
            self._show_camera(state)
            self._show_paths(state)
            self._show_target(state)
        self._look_at(state)

    def colours(self, snapshot: ObjectSnapshot) -> NDArray[np.uint8]:
        """(n, 3) RGB of the object's points."""
        if self.colouring == FRAMES:
            return sequential(np.log2(1.0 + np.asarray(snapshot.frames_seen, np.float64)))
        if self.colouring == NORMAL:
            return directions(snapshot.normals_xyz)
        if self.colouring == EVIDENCE and self.explanation is not None:
            return signed(self.explanation.at(snapshot.points_xyz))
        return sequential(snapshot.points_xyz[:, 2])

    def _pivot(self, snapshot: ObjectSnapshot) -> NDArray[np.float64]:
        """(3,) [m] pivot of the rotation and origin of the object's points."""
        if snapshot.grid is not None:
            return np.asarray(snapshot.grid.grid.centre_xyz)
        return snapshot.points_xyz.mean(axis=0) if len(snapshot.points_xyz) else np.zeros(3)

    def _show_object(self, snapshot: ObjectSnapshot) -> None:
        known, pivot, wxyz = len(snapshot.points_xyz) > 0, self._pivot(snapshot), _about_z(self.yaw)
        local = (snapshot.points_xyz - pivot).astype(np.float16)
        if known or "/object" in self._nodes:
            self._put(
                "/object", self._scene.add_point_cloud, position=pivot, wxyz=wxyz,
                points=local, colors=self.colours(snapshot), point_size=0.009,
                point_shape="circle", point_shading="flat",
            )  # fmt: skip
        if not known:
            self._drop_all("/normals/")
        if not (known and self._visible["normals"]):
            return
        every = -(-len(local) // MOST_NORMALS)
        ends = local[::every] + NORMAL_LENGTH * np.asarray(snapshot.normals_xyz)[::every]
        self._put_lines(
            "/normals/lines", np.stack([local[::every], ends], axis=1), INK, 0.002, pivot, wxyz
        )

    def _show_grid(self, grid: OccupancyGrid | None) -> None:
        drawn = (grid, self.colouring == EVIDENCE, self.explanation)
        same = [a is b for a, b in zip(drawn, self._grid_drawn, strict=False)]
        if same and all(same):
            return
        if grid is None:
            self._drop_all("/grid/")
            self._grid_drawn = ()
            return
        self._grid_drawn = drawn
        boxes, centre = cell_boxes(grid), np.asarray(grid.grid.centre_xyz)
        groups = np.zeros(len(boxes.cells), np.int64)
        colours = np.array([CELL], np.uint8)
        if self.colouring == EVIDENCE and self.explanation is not None:
            evidence = self.explanation.at(boxes.middles_xyz + centre, self.yaw)
            groups, colours = in_groups(evidence)
        for number in range(EVIDENCE_GROUPS):
            name = f"/grid/cells{number}"
            if number >= len(colours):
                self._drop(name)
                continue
            vertices, faces = boxes.mesh(groups == number)
            self._put(
                name, self._scene.add_mesh_simple, position=centre, vertices=vertices,
                faces=faces, color=tuple(int(c) for c in colours[number]),
                opacity=0.25 if len(colours) == 1 else 0.6, flat_shading=True,
                cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        self._put_lines("/grid/outline", outline(grid), OUTLINE, 0.004, centre)

    def _show_camera(self, state: DashboardState) -> None:
        pose = state.T_map_camera
        if pose is None:
            self._drop_all("/camera")
            self._drop_all("/robot")
            self._pictured = None
            return
        known, image = state.camera or PinholeCamera.xtion(), None
        if state.images is not None and state.images is not self._pictured:
            self._pictured = state.images
            seen = state.images.colour
            image = depth_picture(thinned(state.images.depth)) if seen is None else thinned(seen)
        self._put(
            "/camera", self._scene.add_camera_frustum, position=pose.translation,
            wxyz=pose.rotation.as_quat(scalar_first=True), image=image,
            fov=2 * float(np.arctan2(known.height / 2, known.fy)),
            aspect=known.width / known.height, scale=0.25, color=PATH, format="jpeg",
            jpeg_quality=70, thickness=0.006, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        if state.T_base_camera is not None:
            self._show_robot(pose * state.T_base_camera.inv(), state.T_base_camera)

    def _show_robot(self, T_map_base: RigidTransform, T_base_camera: RigidTransform) -> None:
        new = "/robot" not in self._nodes
        self._put(
            "/robot", self._scene.add_frame, position=T_map_base.translation,
            wxyz=T_map_base.rotation.as_quat(scalar_first=True), show_axes=False,
        )  # fmt: skip
        for number, (middle, size) in enumerate(robot_boxes(T_base_camera.translation)):
            if new:
                self._put(
                    f"/robot/{number}", self._scene.add_box, position=middle, color=ROBOT,
                    dimensions=size, cast_shadow=False, receive_shadow=False,
                )  # fmt: skip

    def _show_paths(self, state: DashboardState) -> None:
        for name, path, colour in (
            ("registration", state.path_xyz, PATH), ("odometry", state.odometry_xyz, ODOMETRY),
        ):  # fmt: skip
            every = max(1, len(path) // MOST_VERTICES)
            corners = np.vstack([path[:-1:every], path[-1:]])
            if len(corners) < 2:
                corners = np.zeros((2, 3))
            lines = np.stack([corners[:-1], corners[1:]], axis=1)
            self._put_lines(f"/paths/{name}", lines, colour, 0.012)

    def _show_target(self, state: DashboardState) -> None:
        view = state.target
        if view is None:
            self._drop_all("/target/")
            return
        x, y, faced = view.T_map_base.x, view.T_map_base.y, view.looks_at_xy
        self._put(
            "/target/stand", self._scene.add_cylinder, position=(x, y, 0.01), radius=0.16,
            height=0.01, color=TARGET, opacity=0.6, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._put_lines("/target/sight", np.array([[(x, y, 0.02), (*faced, 0.02)]]), TARGET, 0.006)
        end = np.asarray(faced)
        if view.normal_xy is not None:
            end = end + ARROW_LENGTH * np.asarray(view.normal_xy)
        # The arrow has no length if the planner has no normal.
        arrow = np.array([[(*faced, ARROW_HEIGHT), (*end, ARROW_HEIGHT)]])
        self._put_lines("/target/normal", arrow, TARGET, 0.02)

    def _put_lines(
        self,
        name: str,
        lines: NDArray[np.floating],
        colour: tuple[int, int, int],
        thickness: float,
        position: ArrayLike = (0.0, 0.0, 0.0),
        wxyz: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    ) -> None:
        points = lines.astype(np.float32)
        colours = np.broadcast_to(linear(colour), points.shape)
        self._put(
            name, self._scene.add_line_segments, position=position, wxyz=wxyz, points=points,
            colors=colours, thickness=thickness,
        )  # fmt: skip

    def _put(
        self,
        name: str,
        add: Callable[..., Any],
        position: ArrayLike,
        wxyz: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        **props: Any,
    ) -> None:
        """Add a node, or send its changes; nodes are replaced only if needed."""
        handle = self._nodes.get(name)
        if handle is None:
            self._nodes[name] = add(name, position=position, wxyz=wxyz, **props)
            return
        handle.position, handle.wxyz = position, wxyz
        for prop in CHANGING & props.keys():
            if props[prop] is not None:
                setattr(handle, prop, props[prop])

    def _drop_all(self, beginning: str) -> None:
        """Remove nodes that are not in this state, children before their parents."""
        for name in [name for name in self._nodes if name.startswith(beginning)][::-1]:
            self._drop(name)

    def _drop(self, name: str) -> None:
        handle = self._nodes.pop(name, None)
        if handle is not None:
            handle.remove()

    def _look_at(self, state: DashboardState) -> None:
        """Set the browsers' view to the object from beside the robot's start, once per run."""
        if self._lookout_set or len(state.object_snapshot.points_xyz) == 0:
            return
        extent = state.extent_xyz
        if extent is None:
            points = state.object_snapshot.points_xyz
            extent = np.stack([points.min(axis=0), points.max(axis=0)])
        middle = extent.mean(axis=0).astype(np.float64)
        reach = max(float(np.linalg.norm(extent[1] - extent[0])) / 2, SMALLEST_REACH)
        away = np.array([1.0, -0.4, 0.0])
        if len(state.path_xyz):
            away = (state.path_xyz[0] - middle) * [1.0, 1.0, 0.0]
        away = away / max(float(np.linalg.norm(away)), 1e-6)
        side = np.array([-away[1], away[0], 0.0])
        position, look_at = lookout(middle, reach, -0.9 * away - 2.3 * side)
        with self._server.atomic():
            camera = self._server.initial_camera
            camera.fov, camera.position, camera.look_at = FIELD_OF_VIEW, position, look_at
        # Connected browsers have had nothing else to look at so far.
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.fov = FIELD_OF_VIEW
                client.camera.position, client.camera.look_at = position, look_at
        self._lookout_set = True


def lookout(
    middle_xyz: NDArray[np.float64], reach: float, direction_xyz: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Viewpoint from which an object fills `OBJECT_SHARE` of the view, beside the panel.

    Args:
        middle_xyz: (3,) [m] centre of the object.
        reach: Radius of its bounding sphere [m].
        direction_xyz: (3,) horizontal direction from the object to the viewer.

    Returns:
        (3,) [m] position of the viewer, and (3,) [m] the point at the centre of the view.
    """
    level = direction_xyz / np.linalg.norm(direction_xyz)
    towards = np.array([*(0.88 * level[:2]), 0.47])
    towards /= np.linalg.norm(towards)
    half_height = reach / OBJECT_SHARE
    right = np.array([-level[1], level[0], 0.0])
    look_at = middle_xyz + 2 * half_height * BESIDE_PANEL * right
    return look_at + half_height / np.tan(FIELD_OF_VIEW / 2) * towards, look_at


def _about_z(yaw: float) -> NDArray[np.float64]:
    return Rotation.from_euler("z", yaw).as_quat(scalar_first=True)
