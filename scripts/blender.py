# Do files that Blender writes hold the motion that it was given? Turns BVH files into .glb and .fbx files by way of Blender.
#
# `python3.11 scripts/blender.py OUT_FOLDER FILE.bvh ...`, where Python has Blender as a module (`pip install bpy`, 0.4 GB).
# For each file NAME.bvh, OUT_FOLDER gets NAME.glb and NAME.fbx (joints alone) and `skinned/` the same with a mesh that
# the joints carry, below an armature in centimetres. `--plain` leaves out the latter, `--metres UNIT` says how long a unit
# of the files is. What is written is compared by precompute/motion/tests/blender.rs, which calls this.
import argparse
import os

import bpy


def read(path, metres, scale):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_anim.bvh(
        filepath=path, global_scale=metres / scale, update_scene_fps=True, update_scene_duration=True
    )
    armature = bpy.context.object
    # A scene has 250 frames or more.
    bpy.context.scene.frame_end = int(armature.animation_data.action.frame_range[1])
    armature.scale = (scale, scale, scale)
    return armature


def skin(armature):
    """A triangle at each joint that it alone carries."""
    corners = []
    for bone in armature.data.bones:
        corners += [bone.head_local, bone.head_local + (bone.tail_local - bone.head_local) * 0.1, bone.tail_local]
    mesh = bpy.data.meshes.new("body")
    mesh.from_pydata([tuple(c) for c in corners], [], [(i, i + 1, i + 2) for i in range(0, len(corners), 3)])
    body = bpy.data.objects.new("body", mesh)
    bpy.context.scene.collection.objects.link(body)
    for i, bone in enumerate(armature.data.bones):
        body.vertex_groups.new(name=bone.name).add(range(3 * i, 3 * i + 3), 1.0, "REPLACE")
    body.modifiers.new("skin", "ARMATURE").object = armature
    body.parent = armature


def write(stem):
    bpy.ops.export_scene.gltf(
        filepath=stem + ".glb", export_force_sampling=True, export_optimize_animation_size=False, export_yup=True
    )
    bpy.ops.export_scene.fbx(
        filepath=stem + ".fbx", add_leaf_bones=False, bake_anim_simplify_factor=0.0,
        bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False,
    )


args = argparse.ArgumentParser()
args.add_argument("out")
args.add_argument("files", nargs="+")
args.add_argument("--metres", type=float, default=1.0)
args.add_argument("--plain", action="store_true")
args = args.parse_args()
os.makedirs(os.path.join(args.out, "skinned"), exist_ok=True)
for path in args.files:
    name = os.path.splitext(os.path.basename(path))[0]
    read(path, args.metres, 1.0)
    write(os.path.join(args.out, name))
    if not args.plain:
        skin(read(path, args.metres, 0.01))
        write(os.path.join(args.out, "skinned", name))
