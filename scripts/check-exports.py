# Do other programs read what `throng export` writes as it was meant?
#
# `python3.11 scripts/check-exports.py TAKE.npz FILE ...`: each FILE (.glb, .usda, .bvh, an .npz of one character in
# AMASS's way) holds the same take as TAKE.npz, which NumPy reads; every joint of every frame is compared with it. Python
# needs `numpy`; `usd-core` reads .usda and runs its validators, `bpy` (Blender, 0.4 GB) reads .glb, .usda and .bvh. What is
# not installed is skipped, and that is said. Fails where a joint is farther off than 0.1 mm, or a validator complains.
import argparse
import re
import sys

import numpy as np

LIMIT_M = 1e-4
failures = []


def tell(file, by, worst, count, more=""):
    ok = worst <= LIMIT_M
    print(f"{file}: {by}: {count} joints compared, {worst * 1000:.4f} mm at worst{more}{'' if ok else '  FAILED'}")
    if not ok:
        failures.append(file)


class Take:
    def __init__(self, path):
        data = np.load(path)
        self.positions, self.present = data["positions"], data["present"]
        self.names, self.numbers = list(data["names"]), list(data["characters"])
        self.joints, self.fps = list(data["joints"]), float(data["fps"])
        self.rotations, self.parents, self.offsets = data["rotations"], data["parents"], data["offsets"]
        self.check_mapped(path)

    def check_mapped(self, path):
        """Numbers are stored as they are, at multiples of 64: they can be mapped."""
        import zipfile

        with zipfile.ZipFile(path) as z:
            for info in z.infolist():
                assert info.compress_type == zipfile.ZIP_STORED, info.filename
            info = z.getinfo("positions.npy")
        with open(path, "rb") as f:
            f.seek(info.header_offset + 26)
            name, extra = np.frombuffer(f.read(4), "<u2")
            f.seek(info.header_offset + 30 + int(name) + int(extra))
            version = np.lib.format.read_magic(f)
            assert version == (1, 0), version
            shape, _, kind = np.lib.format.read_array_header_1_0(f)
            at = f.tell()
        mapped = np.memmap(path, kind, "r", at, shape)
        assert at % 64 == 0 and np.array_equal(mapped, self.positions), f"{path}: cannot be mapped"
        print(f"{path}: numpy: {shape[0]} characters, {shape[1]} frames, mapped at byte {at}")

    def places(self, number):
        return self.positions[self.numbers.index(number)]


# Blender: its world has Z up.
def to_y_up(p):
    return np.stack([p[..., 0], p[..., 2], -p[..., 1]], -1)


def blender_scene(path):
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    return bpy, scene


def armature_places(scene, armature, frames, joints):
    """Where joints are, from the first frame of its motion on."""
    out = np.zeros((frames, len(joints), 3))
    bones = [armature.pose.bones[j] for j in joints]
    first = int(armature.animation_data.action.frame_range[0])
    for f in range(frames):
        scene.frame_set(first + f)
        world = armature.matrix_world
        for i, bone in enumerate(bones):
            out[f, i] = (world @ bone.matrix).translation
    return to_y_up(out)


def compare_all(path, take, bpy, scene, by, number_of):
    armatures = [o for o in bpy.data.objects if o.type == "ARMATURE"]
    worst, count, seen = 0.0, 0, {}
    for armature in armatures:
        number = number_of(armature)
        if number is not None:
            seen[number] = armature
    if sorted(seen) != sorted(int(n) for n in take.numbers):
        print(f"{path}: {by}: characters {sorted(seen)}, expected {sorted(take.numbers)}  FAILED")
        failures.append(path)
        return
    frames = take.positions.shape[1]
    out = {n: np.zeros((frames, len(take.joints), 3)) for n in seen}
    bones = {n: [a.pose.bones[j] for j in take.joints] for n, a in seen.items()}
    for f in range(frames):
        scene.frame_set(f)
        for n, armature in seen.items():
            world = armature.matrix_world
            for i, bone in enumerate(bones[n]):
                out[n][f, i] = (world @ bone.matrix).translation
    for n in seen:
        i = take.numbers.index(n)
        there = take.present[i] > 0
        off = np.linalg.norm(to_y_up(out[n]) - take.positions[i], axis=-1)[there]
        worst, count = max(worst, float(off.max(initial=0.0))), count + off.size
    tell(path, by, worst, count, f", {len(seen)} armatures")


def last_number(name):
    found = re.findall(r"\d+", name)
    return int(found[-1]) if found else None


def glb(path, take):
    bpy, scene = blender_scene(path)
    scene.render.fps, scene.render.fps_base = round(take.fps), 1.0
    bpy.ops.import_scene.gltf(filepath=path)

    def number(armature):
        # `walkers 12` is outermost; Blender appends .001 to names that are taken.
        while armature.parent is not None:
            armature = armature.parent
        return last_number(re.sub(r"\.\d{3}$", "", armature.name))

    compare_all(path, take, bpy, scene, f"Blender {bpy.app.version_string}", number)


def usda_in_blender(path, take):
    bpy, scene = blender_scene(path)
    bpy.ops.wm.usd_import(filepath=path)

    def number(armature):
        while armature is not None:
            if re.fullmatch(r"character_\d+(\.\d+)?", armature.name):
                return int(re.match(r"character_(\d+)", armature.name)[1])
            armature = armature.parent
        return None

    # Its joints are called by their paths.
    some = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    names = {b.name.split("/")[-1]: b.name for b in some.pose.bones}
    take.joints = [names.get(j, j) for j in take.joints]
    compare_all(path, take, bpy, scene, f"Blender {bpy.app.version_string}", number)


def usda(path, take, instanced):
    from pxr import Gf, Usd, UsdGeom, UsdSkel, UsdUtils

    stage = Usd.Stage.Open(path)
    complaints = []
    try:
        from pxr import UsdValidation

        registry = UsdValidation.ValidationRegistry()
        context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
        complaints = [f"{e.GetName()}: {e.GetMessage()}" for e in context.Validate(stage)]
        by = "UsdValidation"
    except ImportError:
        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(path)
        complaints = checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
        by = "UsdUtils.ComplianceChecker"
    version = ".".join(map(str, Usd.GetVersion()))
    print(f"{path}: usd-core {version}: {by}: {len(complaints)} complaints" + ("  FAILED" if complaints else ""))
    for c in complaints[:10]:
        print("  ", c)
    if complaints:
        failures.append(path)
    cache = UsdSkel.Cache()
    worst, count, seen = 0.0, 0, 0
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()) if hasattr(Usd.PrimRange, "Stage") else []:
        root = UsdSkel.Root(prim)
        if not root or prim.IsAbstract():
            continue
        cache.Populate(root, Usd.TraverseInstanceProxies())
        number = int(prim.GetName().split("_")[-1])
        skeletons = [p for p in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if p.IsA(UsdSkel.Skeleton)]
        query = cache.GetSkelQuery(UsdSkel.Skeleton(skeletons[0]))
        assert query and query.GetAnimQuery(), f"{prim.GetPath()}: no animation is bound"
        places, present = take.places(number), take.present[take.numbers.index(number)]
        seen += 1
        for f in range(places.shape[0]):
            visible = UsdGeom.Imageable(prim).ComputeVisibility(f) != "invisible"
            assert visible == bool(present[f]), f"{prim.GetPath()}: visibility at {f}"
            if not present[f]:
                continue
            matrices = query.ComputeJointSkelTransforms(f)
            got = np.array([m.ExtractTranslation() for m in matrices])
            worst = max(worst, float(np.linalg.norm(got - places[f], axis=-1).max()))
            count += len(got)
    if seen != len(take.numbers):
        failures.append(path)
    tell(path, f"UsdSkel ({'instances' if instanced else 'plain'})", worst, count, f", {seen} characters")


def bvh(path, take):
    bpy, scene = blender_scene(path)
    number = last_number(path.rsplit("/")[-1].rsplit(".")[0]) if len(take.numbers) > 1 else take.numbers[0]
    bpy.ops.import_anim.bvh(filepath=path, global_scale=0.01, axis_forward="-Z", axis_up="Y", frame_start=0)
    armature = bpy.context.object
    i = take.numbers.index(number)
    there = np.flatnonzero(take.present[i])
    span = range(there[0], there[-1] + 1)
    got = armature_places(scene, armature, len(span), take.joints)
    off = np.linalg.norm(got - take.positions[i][span.start : span.stop], axis=-1)[take.present[i][span.start : span.stop] > 0]
    tell(path, f"Blender {bpy.app.version_string}", float(off.max()), off.size)


SMPL = [
    "hips", "left_thigh", "right_thigh", "spine", "left_shin", "right_shin", "chest", "left_foot", "right_foot",
    "upper_chest", "left_toe", "right_toe", "neck", "left_clavicle", "right_clavicle", "head", "left_upper_arm",
    "right_upper_arm", "left_forearm", "right_forearm", "left_hand", "right_hand",
]


def amass(path, take):
    """SMPL's kinematics, on the lengths of the take: turns of the joints below those above them, Z up."""
    data = np.load(path)
    poses, trans = data["poses"], data["trans"]
    number = last_number(path.rsplit("/")[-1].rsplit(".")[0]) if len(take.numbers) > 1 else take.numbers[0]
    i = take.numbers.index(number)
    assert abs(float(data["mocap_framerate"]) - take.fps) < 1e-9 and poses.shape[1] == 156 and data["betas"].shape == (16,)
    turns = np.zeros((len(poses), 22, 3, 3))
    for k in range(22):
        turns[:, k] = rodrigues(poses[:, 3 * k : 3 * k + 3])
    places = np.zeros((len(poses), 22, 3))
    world = np.zeros_like(turns)
    index = [take.joints.index(j) for j in SMPL]
    for k in range(22):
        parent = take.parents[index[k]]
        if parent < 0:
            places[:, k], world[:, k] = trans, turns[:, k]
            continue
        p = index.index(parent)
        places[:, k] = places[:, p] + world[:, p] @ take.offsets[i][index[k]]
        world[:, k] = world[:, p] @ turns[:, k]
    expected = take.positions[i][:, index]
    there = np.flatnonzero(take.present[i])
    off = np.linalg.norm(to_y_up(places) - expected[there[0] : there[-1] + 1], axis=-1)
    tell(path, "numpy, SMPL's kinematics", float(off.max()), off.size)


def rodrigues(v):
    angle = np.linalg.norm(v, axis=-1)[:, None, None]
    k = np.zeros((len(v), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 0], k[:, 1, 2], k[:, 2, 0], k[:, 2, 1] = (
        -v[:, 2], v[:, 1], v[:, 2], -v[:, 0], -v[:, 1], v[:, 0])
    k = k / np.maximum(angle, 1e-12)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def attempt(name, check, *args):
    try:
        check(*args)
    except ImportError as e:
        print(f"{args[0]}: skipped {name}: {e}")


args = argparse.ArgumentParser()
args.add_argument("take")
args.add_argument("files", nargs="+")
args = args.parse_args()
for file in args.files:
    take = Take(args.take)
    if file.endswith(".glb"):
        attempt("Blender", glb, file, take)
    elif file.endswith(".usda"):
        instanced = "instanceable = true" in open(file).read(100_000_000)
        attempt("usd-core", usda, file, take, instanced)
        if not instanced:
            attempt("Blender", usda_in_blender, file, take)
    elif file.endswith(".bvh"):
        attempt("Blender", bvh, file, take)
    else:
        attempt("numpy", amass, file, take)
sys.exit(1 if failures else 0)
