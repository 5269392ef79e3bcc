# Does the add-on show what is served? `python3.11 scripts/check-blender-live.py THRONG SCENE [PICTURE.png]`, where Python has
# Blender as a module (`pip install bpy`, 0.4 GB). THRONG is the program, SCENE has characters with bodies.
#
# Every joint has to be within 0.1 mm of where the stream says. PICTURE is drawn on the processor.
import os
import re
import subprocess
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import blender_live as addon


def farthest(live):
    """Largest distance of a joint in Blender from the stream's own numbers (m)."""
    bpy.context.view_layer.update()
    frame, stage, most = live.frame, live.stage, 0.0
    roots = dict(zip(np.frombuffer(frame["ids"], "<u4").tolist(), np.frombuffer(frame["roots"], "<f4").reshape(-1, 3)))
    poses = np.frombuffer(frame["poses"], "<f4").reshape(-1, len(stage.joints), 3, 4)
    seen = 0
    for who, pose in zip(np.frombuffer(frame["posed"], "<u4").tolist(), poses):
        if who not in stage.objects or stage.objects[who].type != "ARMATURE":
            continue
        made, (x, z, heading) = stage.objects[who], roots[who]
        for name, (px, py, pz) in zip(stage.joints, pose[:, :, 3]):
            # About +Y by the heading, to the root; then Y up to Z up.
            wx = x + px * np.cos(heading) + pz * np.sin(heading)
            wz = z - px * np.sin(heading) + pz * np.cos(heading)
            there = (made.matrix_world @ made.pose.bones[name].matrix).translation
            most, seen = max(most, (there - Vector((wx, -wz, py))).length), seen + 1
    return most, seen


def picture(live, path):
    scene = bpy.context.scene
    middle = np.mean([made.matrix_world.translation for made in live.stage.objects.values()], axis=0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = Vector(middle) + Vector((0, 9, 3))
    camera.rotation_euler = (Vector(middle) + Vector((0, 0, 0.8)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.matrix_world = 4.0, Matrix.Rotation(0.7, 4, "X")
    ground = bpy.data.meshes.new("ground")
    ground.from_pydata([(-99, -99, 0), (99, -99, 0), (99, 99, 0), (-99, 99, 0)], [], [(0, 1, 2, 3)])
    for made in (camera, sun, bpy.data.objects.new("ground", ground)):
        scene.collection.objects.link(made)
    scene.world = bpy.data.worlds.new("world")
    scene.camera, scene.render.filepath = camera, os.path.abspath(path)
    scene.render.engine, scene.cycles.samples = "CYCLES", 16
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    bpy.ops.render.render(write_still=True)


def main(throng, scene, path=None):
    served = subprocess.Popen(
        [throng, "run", scene, "--serve", "127.0.0.1:0", "--seconds", "5"], stdout=subprocess.PIPE, text=True
    )
    port = int(re.search(r"127\.0\.0\.1:(\d+)", served.stdout.readline()).group(1))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon.register()
    bpy.context.scene.throng_port = port
    bpy.ops.throng.connect()
    live, frames, most, shown = addon.Live, 0, 0.0, None
    # The timer, by hand: Blender has no clock without a window.
    while live.tick() is not None:
        if live.frame is not shown:
            shown, frames = live.frame, frames + 1
            distance, seen = farthest(live)
            most = max(most, distance)
            if path and live.frame["time_s"] > 2.5:
                picture(live, path)
                path = None
    print(f"{frames} frames, {seen} joints in the last, {most:.7f} m off at most; {live.status}")
    addon.unregister()
    print(served.stdout.read().strip())
    assert served.wait() == 0 and seen > 0 and frames > 1 and most < 1e-4


main(*sys.argv[1:])
