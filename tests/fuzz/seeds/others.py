# SPDX-License-Identifier: Apache-2.0
"""Files of SU2, Netgen and TetGen, and answers of plugins."""

import struct


def su2(points, tets, extra):
    rows = [(10, *t) for t in tets] + ([(14, 0, 1, 3, 2, 4)] if extra else [])
    text = f"NDIME= 3\nNELEM= {len(rows)}\n" + "".join(" ".join(map(str, (*row, i))) + "\n" for i, row in enumerate(rows))
    text += f"NPOIN= {len(points)}\n" + "".join(f"{x} {y} {z} {i}\n" for i, (x, y, z) in enumerate(points))
    if extra:
        text += "NMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n5 0 1 2\n9 0 1 3 2\n"
    return text.encode()


def netgen(points, tets, extra):
    """Edges in the form of older files, or with descriptions."""
    text = "mesh3d\ndimension\n3\ngeomtype\n0\nsurfaceelements\n1\n1 1 1 0 3 1 2 3\n"
    text += f"volumeelements\n{len(tets)}\n" + "".join("1 4 " + " ".join(str(t[k] + 1) for k in (0, 2, 1, 3)) + "\n" for t in tets)
    text += "edgesegmentsgi3\n1\n1 2 -1 -1 0 1 0\n" if extra else "edgesegmentsgi2\n1\n1 0 1 2 -1 -1 0 0 1 0 1 1\n"
    text += f"points\n{len(points)}\n" + "".join(f"{x} {y} {z}\n" for x, y, z in points)
    if extra:
        text += ("pointelements\n1\n1 1\nmaterials\n1\n1 steel\nbcnames\n1\n1 a wall\ncd2names\n1\n1 rim\nedgedescriptors\n"
                 "1\n1 0 4 0 0 -1 0 -1 rim\nidentifications\n1\n1 2 1\nidentificationtypes\n1\n2\nface_colours\n1\n1 0 1 0\n")
    return (text + "endmesh\n").encode()


def tetgen(points, tets, extra, base):
    nodes = "".join(f"{i + base} {x} {y} {z} 0.5 {i}\n" for i, (x, y, z) in enumerate(points))
    cells = "".join(f"{i + base} {' '.join(str(v + base) for v in t)} {i}\n" for i, t in enumerate(tets))
    text = f"{len(points)} 3 1 1\n{nodes}%{len(tets)} 4 1\n{cells}"
    if extra:
        text += f"%1 1\n{base} {base} {base + 1} {base + 2} 5\n%1 1\n{base} {base} {base + 1} 7\n"
    return text.encode()


def plugin_answer(points, tets, extra):
    """No error, a warning, and the mesh, as src/io/mesh_stream.hpp has them."""
    out = bytearray()

    def array(form, rows):
        flat = [x for row in rows for x in (row if isinstance(row, tuple) else (row,))]
        out.extend(struct.pack("<Q", len(rows)) + struct.pack(f"<{len(flat)}{form}", *flat))

    def string(text):
        out.extend(struct.pack("<Q", len(text)) + text.encode())

    def data(count):
        out.extend(struct.pack("<Q", 1 if extra else 0))
        if extra:
            string("heat")
            out.extend(struct.pack("<iQ", 1, 0))
            array("d", [0.5] * count)

    triangles = [(0, 1, 2)] if extra else []
    edges = [(0, 1)] if extra else []
    string("")
    out.extend(struct.pack("<Q", 1))
    string("a warning")
    for form, rows in (("d", [tuple(map(float, p)) for p in points]), ("i", [0] * len(points)), ("i", tets),
                       ("i", [1] * len(tets)), ("i", triangles), ("i", [5] * len(triangles)), ("i", edges),
                       ("i", [7] * len(edges))):
        array(form, rows)
    for rows in ([0], [1], [0], [0], [0], [0]) if extra else [[]] * 6:
        array("i", rows)
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        string("Quadrilaterals")
        out.extend(struct.pack("<i", 4))
        for rows in ([0, 1, 3, 2], [9], [0]):
            array("i", rows)
        out.extend(struct.pack("<Q?", 0, False))
    for count in (len(points), len(tets), len(triangles), len(edges)):
        data(count)
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        out.extend(struct.pack("<ii", 3, 1))
        string("steel")
        array("i", [1])
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        out.extend(struct.pack("<iii", 2, 4, 3))
        array("d", [])
        array("i", [(0, 1)])
    for text in ("medit:ref", "", "msh 4.1 binary"):
        string(text)
    return bytes(out) + struct.pack("<?Q?", False, 0, False)
