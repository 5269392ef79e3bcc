#!/usr/bin/env python3
"""Writes a station of two floors as GLB: a hall with shops, stairs, a ramp, a lift, and platforms above.

`scripts/station-level.py [OUT.glb] [--wide N]`; then `throng level OUT.glb --png plan.png`. With `--wide`, N halls stand side
by side, joined by passages. Names of nodes mark places (`goal:...`), closed ground (`no-go`) and the lift (`elevator:...`).
"""

import json
import struct
import sys


class Glb:
    def __init__(self):
        self.bytes, self.views, self.accessors, self.meshes, self.nodes = b"", [], [], [], []
        self.children = set()

    def mesh(self, name, triangles):
        corners = [c for t in triangles for c in t]
        data = b"".join(struct.pack("<3f", *c) for c in corners)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        low, high = [[f(c[i] for c in corners) for i in range(3)] for f in (min, max)]
        view = {"bufferView": len(self.views) - 1, "componentType": 5126, "count": len(corners), "type": "VEC3"}
        self.accessors.append(view | {"min": low, "max": high})
        self.bytes += data
        self.meshes.append({"primitives": [{"attributes": {"POSITION": len(self.accessors) - 1}}]})
        self.nodes.append({"name": name, "mesh": len(self.meshes) - 1})

    def link(self, name, start, end):
        self.nodes.append({"name": name, "translation": start, "children": [len(self.nodes) + 1]})
        self.children.add(len(self.nodes))
        self.nodes.append({"name": "end", "translation": [b - a for a, b in zip(start, end)]})

    def write(self, path):
        roots = [n for n in range(len(self.nodes)) if n not in self.children]
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": self.nodes,
            "meshes": self.meshes, "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.bytes)}],
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes
        with open(path, "wb") as out:
            out.write(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def quad(a, b, c, d):
    return [[a, b, c], [a, c, d]]


def plate(x, z, y):
    """A plate whose height goes from y[0] at x[0] to y[1] at x[1]."""
    return quad([x[0], y[0], z[0]], [x[0], y[0], z[1]], [x[1], y[1], z[1]], [x[1], y[1], z[0]])


def block(x, z, y):
    out = plate(x, z, [y[1], y[1]])
    corners = [[x[0], z[0]], [x[0], z[1]], [x[1], z[1]], [x[1], z[0]]]
    for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1]):
        out += quad([a, y[0], b], [c, y[0], d], [c, y[1], d], [a, y[1], b])
    return out


UPPER, STEP, TREAD = 4.5, 0.15, 0.3


def hall(glb, x0, name):
    """A hall of 40 m x 24 m; platforms above its far half, 4.5 m up."""
    def at(x):
        return [x0 + v for v in x]

    def mark(kind, x, z, y=0.0):
        glb.mesh(f"{kind}", plate(at(x), z, [y + 0.01, y + 0.01]))

    glb.mesh("floor", plate(at([0, 40]), [0, 24], [0, 0]))
    for wall in ([[0, 18], [-0.2, 0]], [[22, 40], [-0.2, 0]], [[0, 40], [24, 24.2]]):
        glb.mesh("wall", block(at(wall[0]), wall[1], [0, 3]))
    # Shops along the near wall, each with a door of 1.6 m.
    for k, x in enumerate([1, 8, 26, 33]):
        glb.mesh("shop", block(at([x, x + 0.2]), [0, 5], [0, 3]) + block(at([x + 6, x + 6.2]), [0, 5], [0, 3]))
        glb.mesh("shop", block(at([x, x + 2.3]), [5, 5.2], [0, 3]) + block(at([x + 3.9, x + 6.2]), [5, 5.2], [0, 3]))
        mark(f"goal:{name} shop {k + 1}", [x + 2, x + 4.5], [1, 3])
        glb.mesh("counter", block(at([x + 5, x + 5.8]), [1, 4], [0, 1.1]))
    for x in (10, 20, 30):
        glb.mesh("column", block(at([x - 0.4, x + 0.4]), [8.6, 9.4], [0, 4.4]))
    mark("no-go", [18, 22], [12, 13])
    mark(f"goal:{name} entrance", [18.5, 21.5], [0.5, 2])
    # Stairs up to the right platform, a ramp to the left one, and a lift between them.
    num = round(UPPER / STEP)
    for k in range(num):
        x = 14 + TREAD * k
        glb.mesh("stairs", block(at([x, x + TREAD]), [15, 18], [STEP * k, STEP * (k + 1)]))
    top = 14 + TREAD * num
    glb.mesh("upper floor", plate(at([top, 40]), [14, 24], [UPPER, UPPER]))
    glb.mesh("upper floor", plate(at([0, 40]), [21, 24], [UPPER, UPPER]))
    glb.mesh("ramp", plate(at([2, 20]), [18.6, 20.4], [0, UPPER]))
    glb.mesh("upper floor", plate(at([20, top]), [18.2, 21], [UPPER, UPPER]))
    mark(f"goal:{name} platform 1", [2, 6], [21.5, 23.5], UPPER)
    mark(f"goal:{name} platform 2", [33, 38], [15, 18], UPPER)
    glb.link(f"elevator:{name} lift", [x0 + 27, 0, 12.5], [x0 + 27, UPPER, 15])


def main():
    out = next((a for a in sys.argv[1:] if a.endswith(".glb")), "station.glb")
    wide = int(sys.argv[sys.argv.index("--wide") + 1]) if "--wide" in sys.argv else 1
    glb = Glb()
    for n in range(wide):
        hall(glb, 44 * n, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"[n % 26] + (str(n // 26) if n >= 26 else ""))
        if n > 0:
            glb.mesh("passage", plate([44 * n - 4, 44 * n], [8, 12], [0, 0]))
    glb.write(out)
    print(out)


if __name__ == "__main__":
    main()
