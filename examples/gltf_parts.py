"""Meshes with textures as one glTF file (`.glb`), with nothing but Python's own library; `park.py` uses it."""

import json
import math
import random
import struct
import zlib


def png(width, height, color):
    """A PNG of `color(x, y)`, three whole numbers, of which 0 to 255 is kept."""
    lines = (bytes(min(max(part, 0), 255) for x in range(width) for part in color(x, y)) for y in range(height))
    lines = b"".join(b"\0" + line for line in lines)

    def chunk(name, data):
        body = name + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b"")


class Meshes:
    """Parts, each of one material, and the bytes that they stand in."""

    def __init__(self):
        self.bytes, self.views, self.accessors = bytearray(), [], []
        self.images, self.materials, self.primitives = [], [], []

    def view(self, data):
        """Puts bytes at a multiple of four."""
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        return len(self.views) - 1

    def painted(self, image):
        """A material of a PNG."""
        self.images.append({"bufferView": self.view(image), "mimeType": "image/png"})
        texture = {"index": len(self.images) - 1}
        return self.material({"baseColorTexture": texture})

    def plain(self, red, green, blue):
        """A material of one albedo."""
        return self.material({"baseColorFactor": [red, green, blue, 1.0]})

    def material(self, surface):
        self.materials.append({"pbrMetallicRoughness": surface | {"metallicFactor": 0.0}})
        return len(self.materials) - 1

    def values(self, values, kind, format_and_type):
        data = struct.pack(f"<{len(values)}{format_and_type[0]}", *values)
        per = {"VEC3": 3, "VEC2": 2, "SCALAR": 1}[kind]
        accessor = {"bufferView": self.view(data), "componentType": format_and_type[1]}
        accessor |= {"count": len(values) // per, "type": kind}
        if kind == "VEC3" and format_and_type[0] == "f":
            accessor |= {"min": [min(values[k::3]) for k in range(3)], "max": [max(values[k::3]) for k in range(3)]}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def part(self, material, surface):
        """A surface: points, normals, places in the texture, and triangles of their numbers."""
        points, normals, places, triangles = surface
        flat = lambda rows: [value for row in rows for value in row]
        attributes = {
            "POSITION": self.values(flat(points), "VEC3", ("f", 5126)),
            "NORMAL": self.values(flat(normals), "VEC3", ("f", 5126)),
            "TEXCOORD_0": self.values(flat(places), "VEC2", ("f", 5126)),
        }
        indices = self.values(flat(triangles), "SCALAR", ("H", 5123))
        self.primitives.append({"attributes": attributes, "indices": indices, "material": material})

    def write(self, path):
        document = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": self.primitives}],
            "materials": self.materials,
            "textures": [{"source": index} for index in range(len(self.images))],
            "images": self.images,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.bytes)}],
        }
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self.bytes) + b"\0" * (-len(self.bytes) % 4)
        chunk = lambda name, body: struct.pack("<I", len(body)) + name + body
        body = chunk(b"JSON", text) + chunk(b"BIN\0", data)
        with open(path, "wb") as file:
            file.write(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def unit(vector):
    length = math.sqrt(sum(value * value for value in vector)) or 1.0
    return tuple(value / length for value in vector)


def grid(columns, rows, point):
    """A surface over `point(u, v)` for u and v from 0 to 1, with normals of its own and the texture once over it."""
    nodes = [[point(i / columns, j / rows) for i in range(columns + 1)] for j in range(rows + 1)]
    points, normals, places, triangles = [], [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            right, left = nodes[j][min(i + 1, columns)], nodes[j][max(i - 1, 0)]
            down, up = nodes[min(j + 1, rows)][i], nodes[max(j - 1, 0)][i]
            a = [right[k] - left[k] for k in range(3)]
            b = [up[k] - down[k] for k in range(3)]
            normals.append(unit((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])))
            points.append(nodes[j][i])
            places.append((i / columns, j / rows))
            if i < columns and j < rows:
                at = j * (columns + 1) + i
                below = at + columns + 1
                triangles += [(at, below, below + 1), (at, below + 1, at + 1)]
    return points, normals, places, triangles


def joined(surfaces):
    """Surfaces of one material as one."""
    points, normals, places, triangles = [], [], [], []
    for surface in surfaces:
        first = len(points)
        triangles += [tuple(first + index for index in triangle) for triangle in surface[3]]
        points, normals, places = points + surface[0], normals + surface[1], places + surface[2]
    return points, normals, places, triangles


def scattered(seed):
    """Numbers that every run draws alike."""
    return random.Random(seed)
