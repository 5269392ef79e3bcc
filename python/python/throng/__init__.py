"""Crowds of characters moved by motion capture.

Metres, seconds, radians. Y is up, heading 0 faces +Z. A root is (x, z, heading). A pose has a matrix of 3 x 4 numbers for
each of 22 joints, from the joint's frame to the character's own.
"""

from __future__ import annotations

import json as _json
import os as _os
from collections.abc import Iterable as _Iterable
from pathlib import Path as _Path
from typing import Any as _Any
from typing import Union as _Union

import numpy as _np
import numpy.typing as _npt

from . import _throng
from ._errors import Error, FileError, InputError
from ._throng import __version__

__all__ = [
    "Bundle", "Characters", "Error", "FileError", "InputError", "Simulation", "build", "export", "load_clip",
]

_Pathlike = _Union[str, "_os.PathLike[str]"]
_Floats = _npt.NDArray[_np.float32]

_U4, _F4 = "<u4", "<f4"
_BYTES = 80
# Rows of sections, as the format has them. Sections that are not here are read as rows of bytes.
_ROWS: dict[str, _Any] = {
    "META": "u1",
    "SKEL": [("offsets", _F4, (22, 3)), ("tips", _F4, (3, 3))],
    "CLIP": [("first_frame", _U4), ("num_frames", _U4), ("mirrored", _U4), ("reserved", _U4)],
    "FRAM": [("planar", _F4, 3), ("height", _F4), ("rotations", "u1", _BYTES)],
    "CONT": "u1",
    "HITS": [
        ("frame", _U4), ("kind", _U4), ("joint", _U4), ("force", _F4), ("position", _F4, 3), ("speed_mps", _F4),
        ("direction", _F4, 3), ("reserved", _U4),
    ],
    "STAT": [("frame", _U4), ("standing", _U4)],
    "SEGM": [
        ("start", _U4), ("num_frames", _U4), ("end", _U4), ("clip", _U4), ("displacement", _F4, 3), ("reserved", _U4),
    ],
    "AOFF": _U4,
    "ASEG": _U4,
    "AERR": _F4,
    "SWEP": [("first_node", _U4), ("num_nodes", _U4), ("radius", _F4)],
    "SWND": [("frame", _U4), ("x", _F4), ("z", _F4)],
    "STOP": [("segment", _U4), ("kind", _U4), ("frames", _U4), ("radius", _F4), ("pose_radius", _F4)],
    "PVAL": _F4,
    "PBST": "u1",
    "GRPS": _U4,
    "BWGT": _F4,
}


class Bundle(_throng.Bundle):
    """An open bundle (``*.throng``): tables of motion, policies and blend spaces.

    The file is read into memory and checked; it may be replaced afterwards.
    """

    def __deepcopy__(self, memo: dict[int, _Any]) -> Bundle:
        """Itself: it never changes."""
        return self

    def sections(self) -> dict[str, tuple[int, int]]:
        """Tags of the sections with their number of rows and bytes a row: ``{"FRAM": (1200, 96), ...}``."""
        return {tag: (rows, size) for tag, rows, size in self._sections()}

    def section(self, tag: str) -> _npt.NDArray[_Any]:
        """Rows of a section as a read-only array that shares the bundle's memory and keeps it alive.

        Rows with several fields are a structured array: ``bundle.section("SEGM")["displacement"]``.
        """
        rows = self._bytes(tag)
        size = self.sections()[tag][1]
        dtype = _np.dtype(_ROWS[tag]) if tag in _ROWS else None
        if dtype is not None and dtype.itemsize == size:
            return rows.view(dtype)
        return rows.reshape(-1, size)

    def query(
        self, states: _npt.ArrayLike, targets: _npt.ArrayLike, behaviour: str | None = None
    ) -> dict[str, _npt.NDArray[_Any]]:
        """Asks a policy which action to take in states of the motion graph.

        - ``states``: numbers of states (n).
        - ``targets``: each in the character's own frame: X left, Y height, Z ahead (n x 3, m).
        - ``behaviour``: its name; the first one by default.

        Returns a dict of arrays: ``stored`` (the best action of the nearest cell), ``best`` (looked ahead), ``segment``
        (of the latter) and ``scores`` (of the best four actions).
        """
        states = _np.asarray(states)
        whole = states.size == 0 or states.dtype.kind in "iu"
        if states.ndim != 1 or not whole or (states.size and not 0 <= states.min() <= states.max() < 2**32):
            raise InputError("`states` must be a list of whole numbers from 0 to 4294967295")
        targets = _numbers("targets", targets, 2)
        return super()._query(states.astype(_np.uint32), targets, behaviour)


# What a GPU needs to pose a character, as the library's documentation has it (32 bytes).
_INSTANCE = _np.dtype([
    ("row_a", _U4), ("row_b", _U4), ("frac", "<u2"), ("blend", "<u2"), ("variant", _U4),
    ("x", _F4), ("y", _F4), ("z", _F4), ("heading", _F4),
])


class Characters(_throng.Characters):
    """Characters who follow one behaviour of a bundle to targets of their own.

    - ``roots``: where they start: x, z, heading (n x 3; m, radians).
    - ``behaviour``: its name; the first one by default.
    - ``avoids``: they keep clear of each other, and start apart.
    - ``instances``: steps also leave records, see ``instances``.
    """

    def __new__(cls, bundle: Bundle, roots: _npt.ArrayLike, *args: _Any, **settings: _Any) -> Characters:
        return super().__new__(cls, bundle, _numbers("roots", roots, 2), *args, **settings)

    def aim(self, targets: _npt.ArrayLike) -> None:
        """Sends every character to a target of its own, from now on (n x 3: x, y, z; m)."""
        super().aim(_numbers("targets", targets, 2))

    @property
    def instances(self) -> _npt.NDArray[_Any]:
        """A record of everybody for a GPU (n, structured, 32 bytes each): a copy; empty unless asked for at first.

        The pose is between frame rows ``row_a`` and the next one (``frac``, 65535 is 1), and ``blend`` of what is at
        ``row_b``, likewise; it stands at ``x``, ``y``, ``z`` and is turned by ``heading``.
        """
        return self._instances().view(_INSTANCE)

    def set_layers(self, who: int, **layers: _Any) -> None:
        """What the body of a character does beside its motion, from now on; without arguments nothing. All fade in and out.

        - ``look_at``: a point that head and neck turn to (m).
        - ``arms``: what the left and the right arm do: None, "wave", "carry_beside", "carry_before", "carry_on_shoulder",
          "phone", or ``{"point": (x, y, z)}``.
        - ``lean``: bend of the trunk forwards and to the left (radians, -0.6 to 0.6).
        - ``clip``: ``first_frame`` and ``num_frames`` of the bundle, which ``joints`` show, a bit for each; ``loops``.
        """
        self._set_layers(who, _json.dumps(layers, default=lambda array: array.tolist()))

    @property
    def events(self) -> list[dict[str, _Any]]:
        """Events of the last step: ``who``, ``kind`` ("footstep", "contact_began", "contact_ended", "tag", "blow"), ``number``
        (of the joint; of the hit; 256 times the clip, plus the tag), ``at`` (m), and ``strength`` (0 to 1)."""
        return [{"who": who, **event} for who, event in _json.loads(self._events())]


class Simulation(_throng.Simulation):
    """A scene that runs.

    ``Simulation("square.toml")`` opens the bundles that the scene names, and builds those that are missing, which it tells
    the logger "throng"; ``cache`` is a folder for what later builds can use again. ``bundle`` takes the place of the
    scene's own. ``text`` is a scene in place of the file's content. With ``untrusted`` it reads only files beside
    the scene or below, and builds nothing: for scenes that strangers sent.

    ``roots`` (n x 3) and ``poses`` (n x 22 x 3 x 4) are read-only arrays of the present moment, made when they are first
    asked for. They tell where everybody is until the next step, which makes new ones: one that is kept goes on to show the
    moment it was asked for. Whoever has left, or has no body, has NaN. ``out=`` writes into memory of the caller's.

    Steps run without Python's lock. While one runs, another thread that asks the same simulation gets a RuntimeError.
    """

    def get_roots(self, out: _Floats | None = None) -> _Floats:
        """The roots: a copy, or written into ``out`` (n x 3, float32)."""
        if out is None:
            return self.roots.copy()
        self._roots_into(_room(out))
        return out

    def get_poses(self, out: _Floats | None = None) -> _Floats:
        """The poses: a copy, or written into ``out`` (n x 22 x 3 x 4, float32)."""
        if out is None:
            return self.poses.copy()
        self._poses_into(_room(out))
        return out


def _numbers(name: str, values: _npt.ArrayLike, dimensions: int) -> _Floats:
    try:
        array = _np.ascontiguousarray(values, dtype=_np.float32)
    except (TypeError, ValueError) as why:
        raise InputError(f"`{name}` must be numbers: {why}") from None
    if array.ndim != dimensions:
        raise InputError(f"`{name}` has {array.ndim} dimensions, expected {dimensions}")
    return array


def _room(out: _Floats) -> _Floats:
    if not isinstance(out, _np.ndarray) or out.dtype != _np.float32:
        raise InputError("`out` must be an array of float32")
    if not out.flags.writeable:
        raise InputError("`out` is read-only")
    return out


def build(
    what: _Pathlike | _Iterable[_Pathlike], out: _Pathlike, cache: _Pathlike | None = None
) -> dict[str, _Any]:
    """Bakes motion files and folders, or one config (``.toml``), into a bundle. Returns the report as a dict.

    Of motion alone, what it allows is made. ``cache`` is a folder for what later builds can use again. An interrupt ends
    the build.
    """
    what = [what] if isinstance(what, (str, _os.PathLike)) else list(what)
    report: dict[str, _Any] = _json.loads(_throng.build(what, out, cache))
    return report


def load_clip(path: _Pathlike) -> dict[str, _Any]:
    """Reads a motion file, on the database skeleton and at the database rate.

    Returns a dict: ``name``, ``rate_hz``, ``root_positions`` (n x 3, m), ``rotations`` (n x 22 x 4, quaternions x, y, z, w
    relative to the parent), ``contacts`` (n, bits) and ``offsets`` (22 x 3, joints at rest relative to the parent, m).
    """
    return _throng.load_clip(path)


def export(
    what: _Pathlike,
    out: _Pathlike,
    format: str | None = None,
    *,
    characters: _Iterable[int] = (),
    from_s: float | None = None,
    to_s: float | None = None,
    fps: float | None = None,
    clips: bool = False,
    onto: _Pathlike | None = None,
    cache: _Pathlike | None = None,
) -> list[_Path]:
    """Lets a scene (``.toml``) or characters of a bundle run, and writes that. Returns the files.

    - ``format``: glb, usda, bvh, npz, amass, csv or instances (of a bundle: which clips play on characters, as NumPy
      arrays); the ending of ``out`` by default. bvh and amass are a file for each character.
    - ``characters``: their numbers; all with bodies by default.
    - ``from_s``, ``to_s``, ``fps``: which part (s), and frames a second; all of it, 30.
    - ``clips``: the clips of a bundle in place of characters.
    - ``onto``: a character of your own (``.glb``) that wears the motion, for glb.
    - ``cache``: as of ``build``; bundles that a scene names and that are missing are built.
    """
    part = (list(characters), from_s, to_s, fps, clips, onto)
    return _throng.export(what, out, format or _Path(out).suffix[1:].lower(), part, cache)
