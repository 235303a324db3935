# SPDX-License-Identifier: Apache-2.0
"""MEDIT text as numpy arrays, {section: array of its rows}, and a few functions of such a mesh. Ids count from 0 in the arrays."""

import re

import numpy

# Columns of a section, and the number of ids among them.
SECTIONS = {"Vertices": (4, 0), "Edges": (3, 2), "Triangles": (4, 3), "Tetrahedra": (5, 4), "Corners": (1, 1), "Ridges": (1, 1),
            "RequiredVertices": (1, 1), "RequiredEdges": (1, 1), "RequiredTriangles": (1, 1)}
FACES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


def read(path):
    text = re.sub(r"#.*", "", path.read_text())
    names = list(re.finditer(r"[A-Z][A-Za-z]{2,}", text))
    mesh = {}
    for name, following in zip(names, names[1:]):
        if name.group() in SECTIONS:
            width, ids = SECTIONS[name.group()]
            words = text[name.end():following.start()].split()
            table = numpy.array(words[1:], dtype=float).reshape(-1, width)
            if name.group() != "Vertices":
                table = table.astype(int)
                table[:, :ids] -= 1
            mesh[name.group()] = table
    return mesh


def write(path, mesh):
    with open(path, "w") as out:
        out.write("MeshVersionFormatted 2\nDimension 3\n")
        for name, (_, ids) in SECTIONS.items():
            if len(mesh.get(name, ())) == 0:
                continue
            out.write(f"{name}\n{len(mesh[name])}\n")
            if name == "Vertices":
                out.writelines(f"{x!r} {y!r} {z!r} {int(tag)}\n" for x, y, z, tag in mesh[name].tolist())
            else:
                table = mesh[name].copy()
                table[:, :ids] += 1
                out.writelines(" ".join(map(str, row)) + "\n" for row in table.tolist())
        out.write("End\n")


def volumes(points, tets):
    """Six times the signed volumes."""
    a, b, c = (points[tets[:, k]] - points[tets[:, 0]] for k in (1, 2, 3))
    return numpy.einsum("ij,ij->i", numpy.cross(a, b), c)


def positive(mesh):
    """The mesh with its tetrahedra listed in the positive order, if most of them are not."""
    tets = mesh["Tetrahedra"]
    if numpy.median(volumes(mesh["Vertices"][:, :3], tets)) < 0:
        tets[:, [2, 3]] = tets[:, [3, 2]]
    return mesh


def skin(tets):
    """The faces between two tags and on one tetrahedron alone, each once."""
    faces = numpy.concatenate([numpy.sort(tets[:, f], axis=1) for f in FACES])
    unique, place, count = numpy.unique(faces, axis=0, return_inverse=True, return_counts=True)
    tags = numpy.tile(tets[:, 4], 4)
    low, high = numpy.full(len(unique), tags.max()), numpy.full(len(unique), tags.min())
    numpy.minimum.at(low, place, tags)
    numpy.maximum.at(high, place, tags)
    return unique[(count == 1) | (low != high)]


def part(mesh, keep):
    """The tetrahedra `keep`, their vertices, and their listed entities."""
    tets = mesh["Tetrahedra"][keep]
    used = numpy.unique(tets[:, :4])
    new_id = numpy.full(len(mesh["Vertices"]), -1)
    new_id[used] = numpy.arange(len(used))
    faces = {tuple(f) for f in numpy.concatenate([numpy.sort(tets[:, f], axis=1) for f in FACES]).tolist()}
    edges = {(f[a], f[b]) for f in faces for a, b in ((0, 1), (0, 2), (1, 2))}
    result = {"Vertices": mesh["Vertices"][used], "Tetrahedra": numpy.column_stack([new_id[tets[:, :4]], tets[:, 4]])}
    for name, there, lists in (("Triangles", faces, ["RequiredTriangles"]), ("Edges", edges, ["RequiredEdges", "Ridges"])):
        table = mesh.get(name, numpy.empty((0, SECTIONS[name][0]), int))
        kept = numpy.array([tuple(sorted(row[:-1])) in there for row in table.tolist()], dtype=bool)
        result[name] = numpy.column_stack([new_id[table[kept, :-1]], table[kept, -1]])
        position = numpy.cumsum(kept) - 1
        for listed in lists:
            rows = mesh.get(listed, numpy.empty((0, 1), int))
            result[listed] = position[rows[kept[rows[:, 0]]]]
    for name in ("Corners", "RequiredVertices"):
        rows = new_id[mesh.get(name, numpy.empty((0, 1), int))]
        result[name] = rows[rows[:, 0] >= 0]
    return result
