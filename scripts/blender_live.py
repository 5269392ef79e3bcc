# An add-on for Blender (3.6 and later) that shows a running scene: `throng run SCENE --serve`.
#
# Install it in Preferences, Add-ons, Install from Disk. Its panel "Throng" is in the sidebar of the 3D view (N).
# Messages are described in docs/live.md. The add-on never waits for the socket, and shows the latest frame that has come.
import socket
import struct

import bpy
import numpy as np
from mathutils import Matrix, Vector

bl_info = {
    "name": "Throng live",
    "author": "Throng",
    "version": (1, 0, 0),
    "blender": (3, 6, 0),
    "location": "3D View > Sidebar > Throng",
    "description": "Shows a running scene of `throng run SCENE --serve`",
    "category": "Animation",
}

EVERY_S = 1 / 60
# Read at most this much at a time, so that Blender goes on (bytes).
AT_ONCE = 64 << 20
# Throng's Y is up, Blender's Z.
UPRIGHT = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
NUMBERS = {0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q", 0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q"}
LENGTHS = {0xC4: ">B", 0xC5: ">H", 0xC6: ">I", 0xD9: ">B", 0xDA: ">H", 0xDB: ">I", 0xDC: ">H", 0xDD: ">I", 0xDE: ">H", 0xDF: ">I"}


def decode(data, at=0):
    """A value of MessagePack, and where the next one begins."""
    tag, at = data[at], at + 1
    if tag < 0x80:
        return tag, at
    if tag >= 0xE0:
        return tag - 256, at
    if tag in (0xC0, 0xC2, 0xC3):
        return {0xC0: None, 0xC2: False, 0xC3: True}[tag], at
    if tag in NUMBERS:
        return struct.unpack_from(NUMBERS[tag], data, at)[0], at + struct.calcsize(NUMBERS[tag])
    if tag in LENGTHS:
        length, at = struct.unpack_from(LENGTHS[tag], data, at)[0], at + struct.calcsize(LENGTHS[tag])
    elif tag < 0xC0:
        length = tag & (0x1F if tag >= 0xA0 else 0x0F)
    else:
        raise ValueError(f"byte {tag:#x} is of no message of Throng")
    if tag in (0xC4, 0xC5, 0xC6):
        return data[at : at + length], at + length
    if 0xA0 <= tag < 0xC0 or tag in (0xD9, 0xDA, 0xDB):
        return str(data[at : at + length], "utf-8"), at + length
    if 0x90 <= tag < 0xA0 or tag in (0xDC, 0xDD):
        out = []
        for _ in range(length):
            value, at = decode(data, at)
            out.append(value)
        return out, at
    out = {}
    for _ in range(length):
        key, at = decode(data, at)
        out[key], at = decode(data, at)
    return out, at


class Stream:
    """Messages of a socket, without waiting."""

    def __init__(self, address, port):
        self.socket = socket.create_connection((address, port), timeout=2.0)
        self.socket.setblocking(False)
        self.data = bytearray()
        self.is_open = True

    def read(self):
        """All messages that have come."""
        read = 0
        while self.is_open and read < AT_ONCE:
            try:
                part = self.socket.recv(1 << 20)
            except BlockingIOError:
                break
            except OSError:
                part = b""
            self.is_open = bool(part)
            self.data += part
            read += len(part)
        out, at = [], 0
        while len(self.data) >= at + 4:
            end = at + 4 + int.from_bytes(self.data[at : at + 4], "little")
            if len(self.data) < end:
                break
            out.append(decode(bytes(self.data[at + 4 : end]))[0])
            at = end
        del self.data[:at]
        return out

    def close(self):
        self.is_open = False
        self.socket.close()


class Stage:
    """Objects for the characters of a scene, made when they are first seen."""

    def __init__(self, hello, most):
        self.joints, self.parents, self.groups, self.most = hello["joints"], hello["parents"], hello["groups"], most
        self.collection = bpy.data.collections.new("Throng")
        bpy.context.scene.collection.children.link(self.collection)
        self.objects, self.rigs, self.events = {}, {}, 0

    def group_of(self, who):
        return next(g for g, group in enumerate(self.groups) if group["first"] <= who < group["first"] + group["count"])

    def rig(self, g):
        """Armature, mesh of its body, and rest matrices of a group (joints x 4 x 4)."""
        if g not in self.rigs:
            at = np.frombuffer(self.groups[g]["offsets"], "<f4").reshape(-1, 3).astype(float)
            for j, parent in enumerate(self.parents):
                at[j] += at[parent] if parent >= 0 else 0.0
            armature = bpy.data.armatures.new(self.groups[g]["name"])
            first = bpy.data.objects.new("rig", armature)
            self.collection.objects.link(first)
            bpy.context.view_layer.objects.active = first
            bpy.ops.object.mode_set(mode="EDIT")
            children = {parent: j for j, parent in reversed(list(enumerate(self.parents)))}
            for j, name in enumerate(self.joints):
                bone = armature.edit_bones.new(name)
                tail = at[children[j]] if j in children else at[j] + 0.4 * (at[j] - at[self.parents[j]])
                bone.head, bone.tail = at[j], tail if np.linalg.norm(tail - at[j]) > 1e-3 else at[j] + (0, 0.05, 0)
                if self.parents[j] >= 0:
                    bone.parent = armature.edit_bones[self.joints[self.parents[j]]]
            bpy.ops.object.mode_set(mode="OBJECT")
            rests = np.array([armature.bones[name].matrix_local for name in self.joints])
            mesh = self.body(armature)
            bpy.data.objects.remove(first)
            self.rigs[g] = armature, mesh, rests
        return self.rigs[g]

    def body(self, armature):
        """A spindle along each bone."""
        corners, faces = [], []
        for bone in armature.bones:
            n = len(corners)
            thick = 0.15 * bone.length
            waist = [(thick, 0.2 * bone.length, 0), (0, 0.2 * bone.length, thick), (-thick, 0.2 * bone.length, 0), (0, 0.2 * bone.length, -thick)]
            corners += [tuple(bone.matrix_local @ Vector(c)) for c in [(0, 0, 0), *waist, (0, bone.length, 0)]]
            faces += [(n, n + 1 + (i + 1) % 4, n + 1 + i) for i in range(4)] + [(n + 5, n + 1 + i, n + 1 + (i + 1) % 4) for i in range(4)]
        mesh = bpy.data.meshes.new(armature.name)
        mesh.from_pydata(corners, [], faces)
        return mesh

    def character(self, who):
        """The object of one: an armature with a body, or an arrow."""
        if who not in self.objects:
            g = self.group_of(who)
            name = f"{self.groups[g]['name']} {who}"
            if self.groups[g]["offsets"] is None:
                made = bpy.data.objects.new(name, None)
                made.empty_display_type, made.empty_display_size = "SINGLE_ARROW", 1.7
            else:
                armature, mesh, _ = self.rig(g)
                made = bpy.data.objects.new(name, armature)
                body = bpy.data.objects.new(f"{name} body", mesh)
                self.collection.objects.link(body)
                for i, joint in enumerate(self.joints):
                    body.vertex_groups.new(name=joint).add(range(6 * i, 6 * i + 6), 1.0, "REPLACE")
                body.modifiers.new("pose", "ARMATURE").object = made
                body.parent = made
            self.collection.objects.link(made)
            # It has no pose before.
            bpy.context.view_layer.update()
            self.objects[who] = made
        return self.objects[who]

    def show(self, frame):
        """Puts everybody where a frame has it; who is not in it is hidden."""
        self.events += len(frame["events"])
        ids = np.frombuffer(frame["ids"], "<u4")[: self.most]
        roots = np.frombuffer(frame["roots"], "<f4").reshape(-1, 3)
        rows = {int(who): row for row, who in enumerate(np.frombuffer(frame["posed"], "<u4"))}
        poses = np.frombuffer(frame["poses"], "<f4").reshape(-1, len(self.joints), 3, 4)
        for made in self.objects.values():
            made.hide_viewport = made.hide_render = True
        for who, (x, z, heading) in zip(ids.tolist(), roots.tolist()):
            made = self.character(who)
            made.hide_viewport = made.hide_render = False
            made.matrix_world = UPRIGHT @ Matrix.Translation((x, 0, z)) @ Matrix.Rotation(heading, 4, "Y")
            if made.type == "ARMATURE" and who in rows:
                self.pose(made, self.rig(self.group_of(who))[2], poses[rows[who]])

    def pose(self, armature, rests, pose):
        """Joints to the character's frame (joints x 3 x 4) as what bones add to their rest."""
        now = np.tile(np.eye(4), (len(pose), 1, 1))
        now[:, :3] = pose
        # Bones lie along limbs, joints at rest do not turn.
        turned = rests.copy()
        turned[:, :3, 3] = 0.0
        now = now @ turned
        for j, (name, parent) in enumerate(zip(self.joints, self.parents)):
            rest, there = (rests[j], now[j]) if parent < 0 else (
                np.linalg.solve(rests[parent], rests[j]), np.linalg.solve(now[parent], now[j]))
            armature.pose.bones[name].matrix_basis = Matrix(np.linalg.solve(rest, there).tolist())


class Live:
    """What is shown: one scene at a time."""

    stream = stage = frame = None
    status = "Not connected"

    @classmethod
    def connect(cls, address, port, most):
        cls.disconnect()
        cls.stream, cls.most, cls.status = Stream(address, port), most, "Connected"
        bpy.app.timers.register(cls.tick)

    @classmethod
    def disconnect(cls):
        if cls.stream:
            cls.stream.close()
        cls.stream, cls.stage, cls.status = None, None, "Not connected"

    @classmethod
    def tick(cls):
        """Shows what has come; returns when to be called again (s)."""
        if cls.stream is None:
            return None
        try:
            messages = cls.stream.read()
        except (ValueError, IndexError, KeyError, struct.error) as why:
            cls.disconnect()
            cls.status = f"Not a scene of Throng: {why}"
            return None
        frames = [m for m in messages if m["kind"] == "frame"]
        for message in messages:
            if message["kind"] == "hello":
                cls.stage = Stage(message, cls.most)
        if frames and cls.stage:
            cls.frame = frames[-1]
            cls.stage.show(cls.frame)
            cls.status = f"{cls.frame['time_s']:.2f} s, {len(cls.stage.objects)} shown"
        if any(m["kind"] == "end" for m in messages) or not cls.stream.is_open:
            cls.stream.close()
            cls.stream, cls.status = None, "The scene has ended"
            return None
        return EVERY_S


class THRONG_OT_connect(bpy.types.Operator):
    bl_idname, bl_label, bl_description = "throng.connect", "Connect", "Shows the scene that is served at the address"

    def execute(self, context):
        scene = context.scene
        try:
            Live.connect(scene.throng_address, scene.throng_port, scene.throng_most)
        except OSError as why:
            self.report({"ERROR"}, f"{scene.throng_address}:{scene.throng_port}: {why}. Start `throng run SCENE --serve` first")
            return {"CANCELLED"}
        return {"FINISHED"}


class THRONG_OT_disconnect(bpy.types.Operator):
    bl_idname, bl_label, bl_description = "throng.disconnect", "Disconnect", "Leaves everybody where they are"

    def execute(self, context):
        Live.disconnect()
        return {"FINISHED"}


class THRONG_PT_panel(bpy.types.Panel):
    bl_idname, bl_label, bl_space_type, bl_region_type, bl_category = "THRONG_PT_panel", "Throng live", "VIEW_3D", "UI", "Throng"

    def draw(self, context):
        for name in ("throng_address", "throng_port", "throng_most"):
            self.layout.prop(context.scene, name)
        self.layout.operator("throng.disconnect" if Live.stream else "throng.connect")
        self.layout.label(text=Live.status)


CLASSES = (THRONG_OT_connect, THRONG_OT_disconnect, THRONG_PT_panel)


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.Scene.throng_address = bpy.props.StringProperty(name="Address", default="127.0.0.1")
    bpy.types.Scene.throng_port = bpy.props.IntProperty(name="Port", default=7468, min=1, max=65535)
    bpy.types.Scene.throng_most = bpy.props.IntProperty(name="Most shown", default=100, min=1)


def unregister():
    Live.disconnect()
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
    for name in ("throng_address", "throng_port", "throng_most"):
        delattr(bpy.types.Scene, name)


if __name__ == "__main__":
    register()
