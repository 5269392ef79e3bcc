# What does an exported file look like in Blender? `python3.11 scripts/picture.py FILE.glb|.usda FRAME OUT.png`, where Python
# has Blender as a module (`pip install bpy`). Drawn by its processor engine: no graphics card is needed.
import math
import sys

import bpy
from mathutils import Vector

path, frame, out = sys.argv[1], int(sys.argv[2]), sys.argv[3]
bpy.ops.wm.read_factory_settings(use_empty=True)
if path.endswith(".glb"):
    bpy.ops.import_scene.gltf(filepath=path)
else:
    bpy.ops.wm.usd_import(filepath=path)
scene = bpy.context.scene
scene.frame_set(frame)
graph = bpy.context.evaluated_depsgraph_get()
corners = []
for o in scene.objects:
    if o.type == "MESH" and not o.hide_render:
        if o.name.startswith("Icosphere"):
            o.hide_render = True
            continue
        mesh = o.evaluated_get(graph).to_mesh()
        step = max(1, len(mesh.vertices) // 50)
        corners += [o.matrix_world @ v.co for v in list(mesh.vertices)[::step]]
low = Vector([min(c[i] for c in corners) for i in range(3)])
high = Vector([max(c[i] for c in corners) for i in range(3)])
centre, size = (low + high) / 2, (high - low).length
bpy.ops.mesh.primitive_plane_add(size=max(40.0, 4 * size), location=(centre.x, centre.y, 0))
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
camera.location = centre + Vector((0.4, -1.0, 0.55)).normalized() * max(3.0, 2.4 * size)
camera.rotation_euler = (centre - camera.location).to_track_quat("-Z", "Y").to_euler()
scene.camera = camera
sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
sun.data.energy, sun.rotation_euler = 2.0, (math.radians(40), math.radians(15), 0)
scene.collection.objects.link(sun)
world = bpy.data.worlds.new("world")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs[0].default_value = (0.35, 0.4, 0.5, 1)
scene.world = world
scene.render.engine = "CYCLES"
scene.cycles.device, scene.cycles.samples = "CPU", 8
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = 960, 540
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
