# Characters of three makes, to try `throng export --onto` with: `python3.11 scripts/make-rigs.py OUT_FOLDER`, where Python has
# Blender as a module (`pip install bpy`). Each has 50 to 80 joints and a mesh of one tube a bone; Blender writes them as .glb.
# mixamo: T-pose, names and chains of Mixamo. unreal: A-pose, twist joints, a root on the ground. rigify: T-pose, long arms,
# short legs, a spine of seven joints; the pelvis does not carry the spine.
import math
import os
import sys

import bpy
from mathutils import Matrix, Vector

SIDES = [("Left", "l", "L", 1), ("Right", "r", "R", -1)]


def fingers(bones, hand, at, way, name, count):
    for k, finger in enumerate(["Thumb", "Index", "Middle", "Ring", "Pinky"]):
        before, place = hand, at + 0.06 * way + Vector((0, 0, 0.03 - 0.018 * k))
        for n in range(1, count + 1):
            bones.append((name(finger, n), before, place.copy(), place + 0.03 * way))
            before, place = name(finger, n), place + 0.03 * way


def body(hips, legs, arms, drop):
    """Places of joints, Y up and facing +Z: hips' height, length of thigh and shin, of upper arm and forearm (m)."""
    at = {"hips": Vector((0, hips, 0)), "chest": Vector((0, hips + 0.42, 0)), "head": Vector((0, hips + 0.66, 0.01))}
    for left, *_, side in SIDES:
        thigh = Vector((side * 0.1, hips - 0.05, 0))
        arm = Vector((side * 0.19, hips + 0.47, -0.01))
        way = Vector((side * math.cos(drop), -math.sin(drop), 0))
        at[left] = dict(thigh=thigh, shin=thigh - Vector((0, legs[0], 0)), foot=thigh - Vector((0, sum(legs), 0)),
                        clavicle=Vector((side * 0.03, hips + 0.47, 0)), arm=arm, forearm=arm + way * arms[0],
                        hand=arm + way * sum(arms), way=way)
    return at


def mixamo():
    at, bones = body(0.98, (0.43, 0.42), (0.29, 0.26), 0.0), []
    p = "mixamorig:"
    spine = [p + "Hips", p + "Spine", p + "Spine1", p + "Spine2", p + "Neck", p + "Head", p + "HeadTop_End"]
    heights = [0.98, 1.08, 1.21, 1.35, 1.52, 1.62, 1.82]
    for i, name in enumerate(spine[:-1]):
        bones.append((name, spine[i - 1] if i else None, Vector((0, heights[i], 0)), Vector((0, heights[i + 1], 0))))
    for left, _, _, side in SIDES:
        b = at[left]
        bones += [(p + left + "UpLeg", p + "Hips", b["thigh"], b["shin"]), (p + left + "Leg", p + left + "UpLeg", b["shin"], b["foot"]),
                  (p + left + "Foot", p + left + "Leg", b["foot"], b["foot"] + Vector((0, -0.06, 0.13))),
                  (p + left + "ToeBase", p + left + "Foot", b["foot"] + Vector((0, -0.06, 0.13)), b["foot"] + Vector((0, -0.06, 0.21))),
                  (p + left + "Shoulder", p + "Spine2", b["clavicle"], b["arm"]), (p + left + "Arm", p + left + "Shoulder", b["arm"], b["forearm"]),
                  (p + left + "ForeArm", p + left + "Arm", b["forearm"], b["hand"]),
                  (p + left + "Hand", p + left + "ForeArm", b["hand"], b["hand"] + b["way"] * 0.08)]
        fingers(bones, p + left + "Hand", b["hand"], b["way"], lambda f, n: f"{p}{left}Hand{f}{n}", 4)
    return bones


def unreal():
    at, bones = body(1.05, (0.47, 0.45), (0.3, 0.27), math.radians(48)), [("root", None, Vector(), Vector((0, 0, 0.1)))]
    spine = ["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"]
    heights = [1.05, 1.13, 1.27, 1.42, 1.58, 1.68, 1.88]
    for i, name in enumerate(spine):
        bones.append((name, spine[i - 1] if i else "root", Vector((0, heights[i], 0)), Vector((0, heights[i + 1], 0))))
    for left, s, _, side in SIDES:
        b = at[left]
        half = lambda a, c, t: a + (c - a) * t
        bones += [(f"thigh_{s}", "pelvis", b["thigh"], b["shin"]), (f"thigh_twist_01_{s}", f"thigh_{s}", half(b["thigh"], b["shin"], 0.3), b["shin"]),
                  (f"calf_{s}", f"thigh_{s}", b["shin"], b["foot"]), (f"calf_twist_01_{s}", f"calf_{s}", half(b["shin"], b["foot"], 0.6), b["foot"]),
                  (f"foot_{s}", f"calf_{s}", b["foot"], b["foot"] + Vector((0, -0.07, 0.14))),
                  (f"ball_{s}", f"foot_{s}", b["foot"] + Vector((0, -0.07, 0.14)), b["foot"] + Vector((0, -0.07, 0.22))),
                  (f"clavicle_{s}", "spine_03", b["clavicle"], b["arm"]), (f"upperarm_{s}", f"clavicle_{s}", b["arm"], b["forearm"]),
                  (f"upperarm_twist_01_{s}", f"upperarm_{s}", half(b["arm"], b["forearm"], 0.4), b["forearm"]),
                  (f"lowerarm_{s}", f"upperarm_{s}", b["forearm"], b["hand"]),
                  (f"lowerarm_twist_01_{s}", f"lowerarm_{s}", half(b["forearm"], b["hand"], 0.6), b["hand"]),
                  (f"hand_{s}", f"lowerarm_{s}", b["hand"], b["hand"] + b["way"] * 0.08)]
        fingers(bones, f"hand_{s}", b["hand"], b["way"], lambda f, n: f"{f.lower()}_{n:02}_{s}", 3)
    return bones


def rigify():
    at, bones = body(0.85, (0.34, 0.36), (0.32, 0.3), 0.0), [("torso", None, Vector((0, 0.85, 0)), Vector((0, 0.85, 0.1)))]
    bones.append(("DEF-pelvis", "torso", Vector((0, 0.85, 0)), Vector((0, 0.8, 0))))
    spine = ["DEF-spine"] + [f"DEF-spine.00{i}" for i in range(1, 7)]
    heights = [0.88, 0.96, 1.06, 1.17, 1.36, 1.41, 1.48, 1.68]
    for i, name in enumerate(spine):
        bones.append((name, spine[i - 1] if i else "torso", Vector((0, heights[i], 0)), Vector((0, heights[i + 1], 0))))
    for left, _, s, side in SIDES:
        b = at[left]
        bones += [(f"DEF-thigh.{s}", "DEF-pelvis", b["thigh"], b["shin"]), (f"DEF-shin.{s}", f"DEF-thigh.{s}", b["shin"], b["foot"]),
                  (f"DEF-foot.{s}", f"DEF-shin.{s}", b["foot"], b["foot"] + Vector((0, -0.07, 0.12))),
                  (f"DEF-toe.{s}", f"DEF-foot.{s}", b["foot"] + Vector((0, -0.07, 0.12)), b["foot"] + Vector((0, -0.07, 0.19))),
                  (f"DEF-shoulder.{s}", "DEF-spine.003", b["clavicle"], b["arm"]), (f"DEF-upper_arm.{s}", f"DEF-shoulder.{s}", b["arm"], b["forearm"]),
                  (f"DEF-forearm.{s}", f"DEF-upper_arm.{s}", b["forearm"], b["hand"]),
                  (f"DEF-hand.{s}", f"DEF-forearm.{s}", b["hand"], b["hand"] + b["way"] * 0.08)]
        fingers(bones, f"DEF-hand.{s}", b["hand"], b["way"], lambda f, n: f"DEF-f_{f.lower()}.{n:02}.{s}", 3)
    return bones


def thickness(name):
    name = name.lower()
    for words, radius in [(("finger", "thumb", "index", "middle", "ring", "pinky"), 0.012), (("root", "torso", "twist"), 0.0),
                          (("toe", "ball"), 0.035), (("foot",), 0.045), (("head",), 0.09), (("neck", "006", "005"), 0.05),
                          (("hand",), 0.03), (("forearm", "lowerarm"), 0.04), (("arm",), 0.05), (("shoulder", "clavicle"), 0.05),
                          (("upleg", "thigh"), 0.08), (("leg", "calf", "shin"), 0.06)]:
        if any(w in name for w in words):
            return radius
    return 0.11


def make(name, bones, out):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    z_up = lambda p: Vector((p.x, -p.z, p.y))
    armature = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, parent, head, tail in bones:
        edit = armature.data.edit_bones.new(bone)
        edit.head, edit.tail = z_up(head), z_up(tail)
        if parent:
            edit.parent = armature.data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    corners, faces, owners = [], [], []
    for bone, _, head, tail in bones:
        radius = thickness(bone)
        if radius == 0.0:
            continue
        head, tail = z_up(head), z_up(tail)
        turn = (tail - head).to_track_quat("Z", "Y").to_matrix().to_4x4()
        first = len(corners)
        for ring, (t, r) in enumerate([(-0.3 * radius, 0.6), (0.0, 1.0), ((tail - head).length, 0.85), ((tail - head).length + 0.3 * radius, 0.5)]):
            for k in range(10):
                angle = 2 * math.pi * k / 10
                corners.append(head + turn @ Vector((radius * r * math.cos(angle), radius * r * math.sin(angle), t)))
                owners.append(bone)
            if ring:
                a = first + 10 * (ring - 1)
                faces += [(a + k, a + (k + 1) % 10, a + 10 + (k + 1) % 10, a + 10 + k) for k in range(10)]
        faces += [tuple(first + k for k in reversed(range(10))), tuple(first + 30 + k for k in range(10))]
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata([tuple(c) for c in corners], [], faces)
    skin = bpy.data.objects.new("skin", mesh)
    bpy.context.scene.collection.objects.link(skin)
    for i, owner in enumerate(owners):
        group = skin.vertex_groups.get(owner) or skin.vertex_groups.new(name=owner)
        group.add([i], 1.0, "REPLACE")
    for bone, *_ in bones:
        if skin.vertex_groups.get(bone) is None:
            skin.vertex_groups.new(name=bone)
    skin.modifiers.new("skin", "ARMATURE").object = armature
    skin.parent = armature
    material = bpy.data.materials.new("cloth")
    material.diffuse_color = (0.8, 0.45, 0.2, 1)
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.4, 0.15, 1)
    mesh.materials.append(material)
    bpy.ops.export_scene.gltf(filepath=os.path.join(out, name + ".glb"), export_animations=False)
    print(name, len(bones), "joints")


out = sys.argv[1]
os.makedirs(out, exist_ok=True)
for name, bones in [("mixamo", mixamo()), ("unreal", unreal()), ("rigify", rigify())]:
    make(name, bones, out)
