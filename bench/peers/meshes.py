# SPDX-License-Identifier: Apache-2.0
"""Conversion of meshes for the other programs, outside of the timed part. Uses the standard library only.

  meshes.py prepare SOURCE MESH [STEM]   the input as every rival gets it: MESH (.mesh or .meshb), and STEM.node, .ele,
                                         .face, .edge
  meshes.py from-tetgen STEM IN OUT      TetGen's result STEM.1.* as the MEDIT file OUT
  meshes.py from-stellar STEM IN OUT     Stellar's result STEM.node, .ele as OUT: it keeps no tags, and all tetrahedra get
                                         the first region of IN
  meshes.py vertices-kept IN OUT         whether vertex i is still vertex i
Each call is a process of its own: the kernel's peak memory of a process is at least that of the one that started it, so
the driver must stay small. Inside, a mesh is a dict: section of a MEDIT file -> flat list of its words, as they stood in
the file, so that no bit is lost."""

import pathlib
import re
import struct
import sys

WIDTHS = {"Vertices": 4, "Edges": 3, "Triangles": 4, "Tetrahedra": 5, "Corners": 1, "Ridges": 1, "RequiredVertices": 1,
          "RequiredEdges": 1, "RequiredTriangles": 1, "RequiredTetrahedra": 1}
CODES = {"Vertices": 4, "Edges": 5, "Triangles": 6, "Tetrahedra": 8, "Corners": 13, "Ridges": 14,
         "RequiredVertices": 15, "RequiredEdges": 16, "RequiredTriangles": 17, "RequiredTetrahedra": 12}  # in .meshb


def read_medit(path):
    if path.suffix != ".mesh":
        raise ValueError(f"{path}: only MEDIT text, .mesh, goes to every rival")
    text = path.read_text()
    if "#" in text:
        text = re.sub(r"#.*", "", text)
    words = [(m.start(), m.end(), m.group()) for m in re.finditer(r"[A-Za-z]{3,}\w*", text)]
    if not words or words[0][2] != "MeshVersionFormatted":
        raise ValueError(f"{path}: not a MEDIT text file")
    mesh = {}
    for k, (_, end, name) in enumerate(words):
        if name not in WIDTHS:
            continue
        body = text[end:words[k + 1][0] if k + 1 < len(words) else len(text)].split()
        if not body or len(body) != 1 + int(body[0]) * WIDTHS[name]:
            raise ValueError(f"{path}: section {name} is not as long as it says")
        mesh[name] = body[1:]
    if not mesh.get("Vertices") or not mesh.get("Tetrahedra"):
        raise ValueError(f"{path}: no tetrahedra")
    return mesh


def write_medit(path, mesh):
    with open(path, "w") as out:
        out.write("MeshVersionFormatted 2\nDimension 3\n")
        for name in WIDTHS:
            if mesh.get(name):
                table = rows(mesh, name)
                out.write(f"{name}\n{len(table)}\n")
                out.writelines(" ".join(row) + "\n" for row in table)
        out.write("End\n")


def write_meshb(path, mesh):
    def section(code, body):
        out.write(struct.pack("=ii", code, out.tell() + 8 + len(body)) + body)

    with open(path, "wb") as out:
        out.write(struct.pack("=ii", 1, 2))  # Mmg reads no version 3
        section(3, struct.pack("=i", 3))
        for name in WIDTHS:
            if mesh.get(name):
                table = rows(mesh, name)
                if name == "Vertices":
                    body = b"".join(struct.pack("=dddi", *map(float, row[:3]), int(row[3])) for row in table)
                else:
                    body = struct.pack(f"={len(mesh[name])}i", *map(int, mesh[name]))
                section(CODES[name], struct.pack("=i", len(table)) + body)
        out.write(struct.pack("=ii", 54, 0))


def rows(mesh, name):
    words, width = mesh.get(name, []), WIDTHS[name]
    return [words[i:i + width] for i in range(0, len(words), width)]


def points(mesh):
    return [tuple(map(float, row[:3])) for row in rows(mesh, "Vertices")]


def keep_surface_triangles(mesh):
    """Removes triangles that constrain nothing: no tag, not required, and inside a region. TetGen's .mesh lists every face
    of every tetrahedron, which Mmg would take for surfaces to keep. Returns how many."""
    triangles = rows(mesh, "Triangles")
    required = {int(i) - 1 for i in mesh.get("RequiredTriangles", [])}
    regions = {}  # of the triangles in question: the regions on their sides
    for i, row in enumerate(triangles):
        if row[3] == "0" and i not in required:
            regions[tuple(sorted(map(int, row[:3])))] = []
    if not regions:
        return 0
    for row in rows(mesh, "Tetrahedra"):
        a, b, c, d = sorted(map(int, row[:4]))
        for face in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)):
            if face in regions:
                regions[face].append(row[4])
    new_id, kept = {}, []
    for i, row in enumerate(triangles):
        sides = regions.get(tuple(sorted(map(int, row[:3]))))
        if row[3] != "0" or i in required or sides is None or len(sides) != 2 or sides[0] != sides[1]:
            new_id[i] = len(new_id) + 1
            kept += row
    mesh["Triangles"] = kept
    if required:
        mesh["RequiredTriangles"] = [str(new_id[i]) for i in sorted(required)]
    return len(triangles) - len(new_id)


def vertices_kept(before, after):
    """"yes" where vertex i of one mesh is vertex i of the other, moved or not; "reordered" where a vertex has the
    position of another one; else the difference in number."""
    old, new = points(before), points(after)
    if len(old) != len(new):
        return f"{len(new) - len(old):+d}"
    place = {p: i for i, p in enumerate(old)}
    return "yes" if all(place.get(p, i) == i for i, p in enumerate(new) if p != old[i]) else "reordered"


def write_tetgen(stem, mesh):
    """stem.node, .ele, .face and .edge, with the tags as markers and region attributes."""
    for ending, name, head in ((".node", "Vertices", "3 0 1"), (".ele", "Tetrahedra", "4 1"),
                               (".face", "Triangles", "1"), (".edge", "Edges", "1")):
        table = rows(mesh, name)
        with open(f"{stem}{ending}", "w") as out:
            out.write(f"{len(table)} {head}\n")
            out.writelines(f"{i + 1} {' '.join(row)}\n" for i, row in enumerate(table))


def table(path, columns):
    """The entries of one of TetGen's files, without their numbers."""
    with open(path) as file:
        lines = [line.split() for line in file if not line.startswith("#")]
    return [row[1:1 + columns] for row in lines[1:1 + int(lines[0][0])]]


def read_stellar(stem, before):
    region = rows(before, "Tetrahedra")[0][4]
    vertices = [word for row in table(f"{stem}.node", 3) for word in [*row, "0"]]
    return {"Vertices": vertices, "Tetrahedra": [word for row in table(f"{stem}.ele", 4) for word in [*row, region]]}


def read_tetgen(stem, before):
    """The output of TetGen with the sections of the input that it does not support. TetGen marks with 1 each piece of
    surface that had no tag, and lists each segment that it found: those stay without tag, and unlisted, here."""
    vertices, tets = table(f"{stem}.node", WIDTHS["Vertices"]), table(f"{stem}.ele", WIDTHS["Tetrahedra"])
    triangles, edges = table(f"{stem}.face", WIDTHS["Triangles"]), table(f"{stem}.edge", WIDTHS["Edges"])
    listed = {tuple(sorted(row[:2])): row[2] for row in rows(before, "Edges")}
    edges = [row for row in edges if row[2] != "1" or tuple(sorted(row[:2])) in listed]
    for row in edges:
        row[2] = "0" if listed.get(tuple(sorted(row[:2]))) == "0" else row[2]
    tags = {row[3] for row in rows(before, "Triangles")}
    untagged = {tuple(sorted(row[:3])) for row in rows(before, "Triangles") if row[3] == "0"}
    for row in triangles:
        if row[3] == "1" and ("1" not in tags or tuple(sorted(row[:3])) in untagged):
            row[3] = "0"
    after = {name: words for name, words in before.items() if name in ("Corners", "RequiredVertices")}
    for name, lines in (("Vertices", vertices), ("Tetrahedra", tets), ("Triangles", triangles), ("Edges", edges)):
        after[name] = [word for row in lines for word in row]
    return after


def main(command, *paths):
    paths = [pathlib.Path(path) for path in paths]
    if command == "prepare":
        mesh = read_medit(paths[0])
        print(keep_surface_triangles(mesh))
        (write_meshb if paths[1].suffix == ".meshb" else write_medit)(paths[1], mesh)
        if paths[2:]:
            write_tetgen(paths[2], mesh)
    elif command == "from-tetgen":
        write_medit(paths[2], read_tetgen(f"{paths[0]}.1", read_medit(paths[1])))
    elif command == "from-stellar":
        write_medit(paths[2], read_stellar(paths[0], read_medit(paths[1])))
    elif command == "vertices-kept":
        print(vertices_kept(read_medit(paths[0]), read_medit(paths[1])))
    else:
        sys.exit(f"unknown: {command}")


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except (OSError, ValueError) as error:
        sys.exit(str(error))
