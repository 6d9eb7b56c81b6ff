"""Writes one object's folder: mesh.obj, mesh.mtl, texture.png and model.yaml."""

import io

import numpy as np

from mesh import DECIMALS, join, validate

MAX_OBJ_BYTES = 400_000
MAX_TEXTURE_BYTES = 150_000


def fnv1a64(data):
    """The 64-bit Fowler-Noll-Vo hash, variant 1a."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = ((value ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return value


def obj_text(mesh):
    """The mesh as Wavefront OBJ with texture coordinates and one smoothing group."""
    coordinates = np.round(mesh.vertices, DECIMALS) + 0.0
    uv, index = np.unique(np.round(mesh.uv.reshape(-1, 2), DECIMALS), axis=0, return_inverse=True)
    lines = ["mtllib mesh.mtl", "usemtl surface", "s 1"]
    lines += ["v %.5f %.5f %.5f" % tuple(v) for v in coordinates]
    lines += ["vt %.5f %.5f" % tuple(t) for t in uv]
    lines += ["f %d/%d %d/%d %d/%d" % tuple(np.stack([face, corner], 1).ravel() + 1)
              for face, corner in zip(mesh.faces, index.reshape(-1, 3))]
    return "\n".join(lines) + "\n"


def mtl_text(specular, shininess):
    return (f"newmtl surface\nKa 1 1 1\nKd 1 1 1\nKs {specular} {specular} {specular}\n"
            f"Ns {shininess}\nd 1\nillum 2\nmap_Kd texture.png\n")


def write(folder, name, item):
    """Validates an object and writes its folder; returns its extent and triangle count."""
    validate(name, item.parts)
    mesh = join(item.parts)
    png = io.BytesIO()
    item.atlas.image.save(png, format="PNG", optimize=True)
    files = {"mesh.obj": obj_text(mesh).encode(),
             "mesh.mtl": mtl_text(item.specular, item.shininess).encode(),
             "texture.png": png.getvalue()}
    for file, limit in (("mesh.obj", MAX_OBJ_BYTES), ("texture.png", MAX_TEXTURE_BYTES)):
        if len(files[file]) > limit:
            raise ValueError(f"{name}: {file} has {len(files[file])} bytes, over {limit}")
    content_hash = fnv1a64(b"".join(files.values()))
    files["model.yaml"] = (f"format: 1\nname: {name}\nmesh: mesh.obj\nunit: m\n"
                           f'hash: "{content_hash:016x}"\n').encode()
    folder.mkdir(parents=True, exist_ok=True)
    for file, data in files.items():
        (folder / file).write_bytes(data)
    return np.ptp(mesh.vertices, axis=0), len(mesh.faces)
