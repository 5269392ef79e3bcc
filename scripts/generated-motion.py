#!/usr/bin/env python3
"""Writes motion as programs that generate it from text do: Kimodo's NPZ, BVH and GLB of the body SOMA, and SMPL-X.

    throng export walk.bvh --format npz --out walk.npz
    python3 scripts/generated-motion.py walk.npz FOLDER
    throng inspect FOLDER

The files have the joint names, axes, units and arrays of https://research.nvidia.com/labs/sil/projects/kimodo
(output formats). With them, the way from text to a crowd can be tried without a model. NumPy is needed.
"""

import json
import struct
import sys
from pathlib import Path

import numpy as np

FINGERS = [("Thumb", 3, 0.03), ("Index", 4, 0.02), ("Middle", 4, 0.0), ("Ring", 4, -0.02), ("Pinky", 4, -0.04)]
# Joint of the generated body: joint of ours.
BODY = {"Hips": "hips", "Spine1": "spine", "Spine2": "chest", "Chest": "upper_chest", "Neck1": "neck", "Head": "head"}
LIMBS = {"Shoulder": "clavicle", "Arm": "upper_arm", "ForeArm": "forearm", "Hand": "hand", "Leg": "thigh",
         "Shin": "shin", "Foot": "foot", "ToeBase": "toe"}
SMPLX = ["hips", "left_thigh", "right_thigh", "spine", "left_shin", "right_shin", "chest", "left_foot", "right_foot",
         "upper_chest", "left_toe", "right_toe", "neck", "left_clavicle", "right_clavicle", "head", "left_upper_arm",
         "right_upper_arm", "left_forearm", "right_forearm", "left_hand", "right_hand"]
SOMA30 = ["Hips", "Spine1", "Spine2", "Chest", "Neck1", "Neck2", "Head", "Jaw", "LeftEye", "RightEye"]
for side in ("Left", "Right"):
    SOMA30 += [side + part for part in ("Shoulder", "Arm", "ForeArm", "Hand", "HandThumbEnd", "HandMiddleEnd")]
for side in ("Left", "Right"):
    SOMA30 += [side + part for part in ("Leg", "Shin", "Foot", "ToeBase")]


def soma_joints(offsets):
    """Name, parent and offset (m) of the 77 joints of SOMA, in the order of its files."""
    half = 0.5 * offsets["head"]
    out = [(name, parent, offsets[BODY[name]]) for name, parent in
           zip(["Hips", "Spine1", "Spine2", "Chest", "Neck1"], [None, "Hips", "Spine1", "Spine2", "Chest"])]
    out += [("Neck2", "Neck1", half), ("Head", "Neck2", half), ("HeadEnd", "Head", [0, 0.2, 0]),
            ("Jaw", "Head", [0, 0.02, 0.03]), ("LeftEye", "Head", [0.03, 0.07, 0.08]),
            ("RightEye", "Head", [-0.03, 0.07, 0.08])]
    for side, sign in (("Left", 1), ("Right", -1)):
        ours = lambda part: offsets[f"{side.lower()}_{LIMBS[part]}"]
        for part, above in (("Shoulder", "Chest"), ("Arm", side + "Shoulder"), ("ForeArm", side + "Arm"),
                            ("Hand", side + "ForeArm")):
            out.append((side + part, above, ours(part)))
        for finger, count, z in FINGERS:
            above, at = side + "Hand", [sign * 0.05, 0, z]
            for name in [f"{finger}{k + 1}" for k in range(count)] + [finger + "End"]:
                out.append((f"{side}Hand{name}", above, at))
                above, at = f"{side}Hand{name}", [sign * 0.025, 0, 0.2 * z]
    for side in ("Left", "Right"):
        above = "Hips"
        for part in ("Leg", "Shin", "Foot", "ToeBase"):
            out.append((side + part, above, offsets[f"{side.lower()}_{LIMBS[part]}"]))
            above = side + part
        out.append((side + "ToeEnd", above, [0, 0, 0.07]))
    return [(n, p, np.asarray(o, float)) for n, p, o in out]


def matrices(q):
    """Rotation matrices of quaternions x, y, z, w."""
    x, y, z, w = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
            1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
            1 - 2 * (x * x + y * y)]
    return np.stack(rows, -1).reshape(*q.shape[:-1], 3, 3)


def quaternions(m):
    """Quaternions x, y, z, w of rotation matrices."""
    t = np.stack([m[..., 0, 0] - m[..., 1, 1] - m[..., 2, 2], m[..., 1, 1] - m[..., 0, 0] - m[..., 2, 2],
                  m[..., 2, 2] - m[..., 0, 0] - m[..., 1, 1], m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]], -1)
    q = 0.5 * np.sqrt(np.maximum(t + 1, 0))
    signs = np.stack([m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], -1)
    q[..., :3] = np.copysign(q[..., :3], signs)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def axis_angles(m):
    q = quaternions(m)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., 3:])
    return np.where(sine > 1e-9, q[..., :3] / np.maximum(sine, 1e-9) * angle, 0)


def zyx_degrees(m):
    """Angles of rotations about Z, then Y, then X."""
    y = np.arcsin(np.clip(-m[..., 2, 0], -1, 1))
    z, x = np.arctan2(m[..., 1, 0], m[..., 0, 0]), np.arctan2(m[..., 2, 1], m[..., 2, 2])
    return np.degrees(np.unwrap(np.stack([z, y, x], -1), axis=0))


def pose(joints, local, root):
    """Places and turns of all joints in the world."""
    index = {name: k for k, (name, _, _) in enumerate(joints)}
    places, turns = np.zeros((*local.shape[:2], 3)), np.zeros(local.shape)
    for k, (_, parent, offset) in enumerate(joints):
        if parent is None:
            places[:, k], turns[:, k] = root, local[:, k]
        else:
            p = index[parent]
            places[:, k], turns[:, k] = places[:, p] + turns[:, p] @ offset, turns[:, p] @ local[:, k]
    return places, turns


def write_npz(path, joints, local, root):
    places, turns = pose(joints, local, root)
    frames = len(root)
    heading = np.stack([turns[:, 0, 2, 2], turns[:, 0, 0, 2]], -1)
    np.savez(path, posed_joints=places.astype("f4"), global_rot_mats=turns.astype("f4"),
             local_rot_mats=local.astype("f4"), foot_contacts=np.zeros((frames, 4), "f4"),
             smooth_root_pos=root.astype("f4"), root_positions=root.astype("f4"),
             global_root_heading=heading.astype("f4"))


def write_bvh(path, joints, local, root, fps, own_axes):
    """Joints below a root at the origin, turns about Z, Y and X, centimetres, chains without ends.

    own_axes: the rest pose is no body: the offset of each joint to the next one lies along +X, as capture systems write it.
    """
    index = {name: k for k, (name, _, _) in enumerate(joints)}
    below = {name: [n for n, p, _ in joints if p == name] for name, _, _ in joints}
    axes = {}
    for name, parent, offset in joints:
        ends = [o for n, p, o in joints if p == name and np.linalg.norm(o) > 1e-6]
        along = ends[0] / np.linalg.norm(ends[0]) if ends else np.array([0, 1.0, 0])
        across = np.cross(along, [0, 0, 1.0] if abs(along[2]) < 0.9 else [1.0, 0, 0])
        across /= np.linalg.norm(across)
        axes[name] = np.stack([along, across, np.cross(along, across)], -1) if own_axes else np.eye(3)
    lines, order = ["HIERARCHY", "ROOT Root", "{", "  OFFSET 0 0 0"], []
    six = "CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation"
    lines.append("  " + six)

    def joint(name, depth):
        pad, (_, parent, offset) = "  " * depth, joints[index[name]]
        offset = 100 * (offset if parent is None else axes[parent].T @ offset)
        order.append(name)
        lines.extend([f"{pad}JOINT {name}", pad + "{", f"{pad}  OFFSET " + " ".join(f"{v:.6f}" for v in offset)])
        lines.append(f"{pad}  " + (six if parent is None else "CHANNELS 3 Zrotation Yrotation Xrotation"))
        for child in below[name]:
            joint(child, depth + 1)
        lines.append(pad + "}")

    joint("Hips", 1)
    lines.extend(["}", "MOTION", f"Frames: {len(root)}", f"Frame Time: {1 / fps}"])
    columns = [np.zeros((len(root), 6))]
    for name in order:
        k, parent = index[name], joints[index[name]][1]
        if parent is None:
            columns.append(100 * root)
        above = np.eye(3) if parent is None else axes[parent].T
        columns.append(zyx_degrees(above @ local[:, k] @ axes[name]))
    lines += [" ".join(f"{v:.6f}" for v in row) for row in np.concatenate(columns, -1)]
    path.write_text("\n".join(lines) + "\n")


def write_glb(path, joints, local, root, fps):
    """The joints as nodes, and an animation that moves them."""
    index = {name: k for k, (name, _, _) in enumerate(joints)}
    data, views, accessors = bytearray(), [], []

    def numbers(values, kind):
        values = np.ascontiguousarray(values, "<f4")
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(values), "type": kind})
        if kind == "SCALAR":
            accessors[-1].update(min=[float(values.min())], max=[float(values.max())])
        data.extend(values.tobytes())
        return len(accessors) - 1

    nodes = []
    for name, _, offset in joints:
        children = [index[n] for n, p, _ in joints if p == name]
        nodes.append({"name": name, "translation": offset.tolist(), **({"children": children} if children else {})})
    times = numbers(np.arange(len(root)) / fps, "SCALAR")
    tracks = [(0, "translation", numbers(root, "VEC3"))]
    for k in range(len(joints)):
        q = quaternions(local[:, k])
        flips = np.cumprod(np.where((q[1:] * q[:-1]).sum(-1) < 0, -1, 1))
        q[1:] *= flips[:, None]
        tracks.append((k, "rotation", numbers(q, "VEC4")))
    animation = {"name": path.stem, "channels": [], "samplers": []}
    for node, what, values in tracks:
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": {"node": node, "path": what}})
        animation["samplers"].append({"input": times, "output": values, "interpolation": "LINEAR"})
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
                "animations": [animation], "accessors": accessors, "bufferViews": views,
                "buffers": [{"byteLength": len(data)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = [(b"JSON", text), (b"BIN\0", bytes(data))]
    body = b"".join(struct.pack("<I", len(c)) + kind + c for kind, c in chunks)
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def write_amass(path, local, root, fps, z_up):
    """SMPL-X as Kimodo writes it beside its own file: axis times angle, in a world with Z up or with Y up."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]) if z_up else np.eye(3)
    turns = axis_angles(np.concatenate([(turn @ local[:, :1]), local[:, 1:]], 1))
    np.savez(path, trans=(root @ turn.T).astype("f4"), root_orient=turns[:, 0].astype("f4"),
             pose_body=turns[:, 1:].reshape(len(root), 63).astype("f4"), betas=np.zeros(16, "f4"), gender="neutral",
             mocap_frame_rate=float(fps), surface_model_type="smplx")


def main(source, folder):
    take, folder = np.load(source), Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    names, stem = [str(n) for n in take["joints"]], Path(source).stem
    fps, at = float(take["fps"]), {n: k for k, n in enumerate(names)}
    root = take["positions"][0, :, 0].astype(float)
    turns = matrices(take["rotations"][0].astype(float))
    offsets = {n: take["offsets"][0, k].astype(float) for n, k in at.items()}
    joints = soma_joints(offsets)
    ours = dict(BODY)
    ours.update({s + part: f"{s.lower()}_{our}" for s in ("Left", "Right") for part, our in LIMBS.items()})
    local = np.tile(np.eye(3), (len(root), len(joints), 1, 1))
    for k, (name, _, _) in enumerate(joints):
        if name in ours:
            local[:, k] = turns[:, at[ours[name]]]
    write_npz(folder / f"{stem}-soma77.npz", joints, local, root)
    kept = [k for k, (name, _, _) in enumerate(joints) if name in SOMA30]
    parents = {name: parent for name, parent, _ in joints}

    def nearest(name):
        above = parents[name]
        while above and above not in SOMA30:
            above = parents[above]
        return above

    # Ends of fingers hang on the hand here.
    still = pose(joints, np.tile(np.eye(3), (1, len(joints), 1, 1)), np.zeros((1, 3)))[0][0]
    index = {n: k for k, (n, _, _) in enumerate(joints)}
    fewer = [(n, nearest(n), o if nearest(n) is None else still[index[n]] - still[index[nearest(n)]])
             for n, _, o in (joints[k] for k in kept)]
    write_npz(folder / f"{stem}-soma30.npz", fewer, local[:, kept], root)
    write_bvh(folder / f"{stem}-soma.bvh", joints, local, root, fps, own_axes=False)
    write_bvh(folder / f"{stem}-soma-axes.bvh", joints, local, root, fps, own_axes=True)
    write_glb(folder / f"{stem}-soma.glb", joints, local, root, fps)
    own = {"hips": None, "spine": "hips", "chest": "spine", "upper_chest": "chest", "neck": "upper_chest", "head": "neck"}
    chains = {"arm": ["clavicle", "upper_arm", "forearm", "hand"], "leg": ["thigh", "shin", "foot", "toe"]}
    for side in ("left_", "right_"):
        for above, chain in (("upper_chest", chains["arm"]), ("hips", chains["leg"])):
            for part in chain:
                own[side + part], above = above, side + part
    smpl = [(n, own[n], offsets[n]) for n in SMPLX]
    of_smpl = np.stack([turns[:, at[n]] for n in SMPLX], 1)
    write_npz(folder / f"{stem}-smplx22.npz", smpl, of_smpl, root)
    write_amass(folder / f"{stem}-smplx22_amass.npz", of_smpl, root, fps, z_up=True)
    write_amass(folder / f"{stem}-smplx22_amass-y.npz", of_smpl, root, fps, z_up=False)
    assert len(joints) == 77 and len(fewer) == 30


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
