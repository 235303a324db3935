# SPDX-License-Identifier: Apache-2.0
"""Meshes from seeds. A family is a function of a random.Random and an empty folder to work in; it returns a mesh as medit.read()
does, or None if the mesher fails on the shape."""

import math
import subprocess

import numpy

import medit
import robustness  # bench/paper: its star-shaped polyhedra

MESHER_SECONDS = 30


def star(rng, folder):
    """TetGen's of noisy spheres of flat facets, plates and needles, some hollow: as in bench/paper/run --robustness."""
    mesh = robustness.make_mesh(rng.randrange(1, 10**6), folder)
    return medit.read(mesh) if mesh else None


def shells(rng, folder):
    """TetGen's of rough balls, in each a cavity or a second material whose surface runs close to the outer one."""
    points, faces = robustness.icosphere(rng.choice((2, 2, 3)))
    noise = rng.choice((0.02, 0.1, 0.3))
    dents = [([rng.uniform(-1, 1) for _ in range(3)], rng.uniform(2, 6), rng.uniform(-0.25, 0.25)) for _ in range(3)]
    gap = rng.choice((0.02, 0.05, 0.1, 0.3))
    outer = []
    for p in points:
        r = 1 + noise * (rng.random() - 0.5) * 0.5
        r += sum(h * math.exp(-k * sum((a - b) ** 2 for a, b in zip(p, at))) for at, k, h in dents)
        outer.append([r * x for x in p])
    inner = [[(1 - gap) * x for x in p] for p in outer]
    n = len(points)
    everything = outer + inner
    facets = [(f, 1) for f in faces] + [((a + n, c + n, b + n), 2) for a, b, c in faces]
    hollow = rng.random() < 0.5
    lines = [f"{2 * n} 3 0 0"] + [f"{i + 1} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(everything)]
    lines += [f"{len(facets)} 1"] + [f"3 {a + 1} {b + 1} {c + 1} {tag}" for (a, b, c), tag in facets]
    lines += ["1", "1 0 0 0", "0"] if hollow else ["0", "2", "1 0 0 0 1"]
    if not hollow:
        top = outer[0]
        lines.append("2 " + " ".join(repr((1 - gap / 2) * x) for x in top) + " 2")
    (folder / "m.smesh").write_text("\n".join(lines) + "\n")
    quality = rng.choice(("", "q2.0", "q1.4"))
    command = ["tetgen", f"-p{quality}a{4 / rng.choice((1000, 4000, 10000)):.9f}{'' if hollow else 'A'}O0/0gz", "m.smesh"]
    try:
        subprocess.run(command, cwd=folder, capture_output=True, timeout=MESHER_SECONDS, check=True)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
        return None
    mesh = folder / "m.1.mesh"
    return medit.read(mesh) if mesh.exists() else None


def grid(counts):
    """The unit box of counts[0] x counts[1] x counts[2] cells, each cut into six tetrahedra around its diagonal."""
    axes = [numpy.arange(n + 1) for n in counts]
    x, y, z = (a.ravel() for a in numpy.meshgrid(*axes, indexing="ij"))
    points = numpy.column_stack([x, y, z]) / counts
    stride = numpy.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    first = numpy.add.outer(numpy.add.outer(stride[0] * axes[0][:-1], stride[1] * axes[1][:-1]), stride[2] * axes[2][:-1]).ravel()
    tets = []
    for odd, path in enumerate(((0, 1, 2), (0, 2, 1), (1, 2, 0), (1, 0, 2), (2, 0, 1), (2, 1, 0))):
        corners = [first]
        for axis in path:
            corners.append(corners[-1] + stride[axis])
        if odd % 2:
            corners[2:] = reversed(corners[2:])
        tets.append(numpy.column_stack(corners))
    tets = numpy.concatenate(tets)
    inside = numpy.column_stack([(c > 0) & (c < n) for c, n in zip((x, y, z), counts)])  # which coordinates may be displaced
    return points, tets, inside


def assembled(points, tets, tags, moved=None):
    """The mesh; its points `moved`, or on the way there as far as every volume stays positive."""
    mesh = medit.positive({"Vertices": numpy.column_stack([points, numpy.zeros(len(points))]),
                           "Tetrahedra": numpy.column_stack([tets, tags])})
    if moved is not None:
        tets = mesh["Tetrahedra"]
        least = 1e-3 * medit.volumes(points, tets)
        share = 1
        while (medit.volumes(points + share * (moved - points), tets) < least).any():
            share *= 0.8
        mesh["Vertices"][:, :3] = points + share * (moved - points)
    return mesh


def noise(rng, shape):
    return numpy.random.default_rng(rng.randrange(2**32)).uniform(-1, 1, shape)


def lattice(rng, _):
    """Jittered lattices, even or graded in size, of one material, layers, balls or loose cells; squeezed and sheared."""
    n = rng.randrange(5, 19)
    counts = numpy.array([max(3, round(n * rng.uniform(0.7, 1.3))) for _ in range(3)])
    points, tets, inside = grid(counts)
    moved = points + rng.uniform(0, 0.45) * inside * noise(rng, points.shape) / counts
    centers = points[tets].mean(axis=1)
    kind = rng.choice(("one", "layers", "balls", "cells"))
    tags = numpy.ones(len(tets), int)
    if kind == "layers":
        axis, layers = rng.randrange(3), rng.randrange(2, 5)
        tags = 1 + (centers[:, axis] * layers).astype(int)
    elif kind == "balls":
        for tag in range(2, 2 + rng.randrange(1, 6)):
            at, radius = [rng.random() for _ in range(3)], rng.uniform(0.1, 0.4)
            tags[numpy.linalg.norm(centers - at, axis=1) < radius] = tag
    elif kind == "cells":
        cell = (centers * counts).astype(int) @ [1, 7919, 104729]
        tags = 1 + (cell * 2654435761 % 2**32 < 2**32 * rng.uniform(0.02, 0.3)).astype(int)
    if rng.random() < 0.5:  # grading keeps planes
        for k in range(3):
            ratio = rng.uniform(-5, 5)
            points[:, k], moved[:, k] = (numpy.expm1(ratio * p[:, k]) / math.expm1(ratio) for p in (points, moved))
    shear = numpy.diag([rng.uniform(0.3, 2) for _ in range(3)]) + 0.3 * noise(rng, (3, 3)) * rng.choice((0, 1))
    if numpy.linalg.det(shear) < 0.01:
        shear = numpy.eye(3)
    scale = 10 ** rng.uniform(-6, 6)
    return assembled(points @ shear * scale, tets, tags, moved @ shear * scale)


def plate(rng, _):
    """Thin plates of one to four layers, plane or bent, as wide as 20 to 1000 times their thickness."""
    layers, wide, deep = rng.randrange(1, 5), rng.randrange(12, 45), rng.randrange(8, 30)
    points, tets, inside = grid(numpy.array([wide, deep, layers]))
    moved = points + rng.uniform(0, 0.45) * inside * noise(rng, points.shape) / (wide, deep, layers)
    tags = 1 + (points[tets].mean(axis=1)[:, 2] * layers).astype(int) if rng.random() < 0.5 else numpy.ones(len(tets), int)
    thickness, bend = 1 / 10 ** rng.uniform(1.3, 3), rng.choice((0, 0, rng.uniform(0.2, 3)))

    def bent(p):
        x, y, z = p[:, 0], deep / wide * p[:, 1], thickness * (p[:, 2] - 0.5)
        if bend == 0:
            return numpy.column_stack([x, y, z])
        return numpy.column_stack([(1 / bend + z) * numpy.sin(bend * x), y, (1 / bend + z) * numpy.cos(bend * x)])

    signs = numpy.sign(medit.volumes(bent(points), tets))
    if abs(signs.sum()) < len(signs):
        bend = 0  # so thin that its chords cut through it
    return assembled(bent(points), tets, tags, bent(moved))


def solid(rng, folder):
    """Gmsh's of two to six boxes, balls and cylinders: parts of several materials, or one body, united or cut."""
    count = rng.randrange(2, 7)
    lines = ['SetFactory("OpenCASCADE");', "General.NumThreads = 1; Mesh.Optimize = 0; Mesh.OptimizeNetgen = 0; Mesh.SaveAll = 1;"]
    for i in range(1, count + 1):
        at = ", ".join(f"{rng.uniform(0, 1):.6f}" for _ in range(3))
        kind = rng.choice(("Box", "Box", "Sphere", "Cylinder"))
        if kind == "Sphere":
            lines.append(f"Sphere({i}) = {{{at}, {rng.uniform(0.2, 0.6):.6f}}};")
        else:
            sides = ", ".join(f"{rng.uniform(0.3, 1):.6f}" for _ in range(3))
            lines.append(f"{kind}({i}) = {{{at}, {sides}" + (f", {rng.uniform(0.1, 0.4):.6f}}};" if kind == "Cylinder" else "};"))
        axis = ", ".join(f"{rng.uniform(-1, 1):.6f}" for _ in range(3))
        if rng.random() < 0.5:
            lines.append(f"Rotate {{{{{axis}}}, {{0.5, 0.5, 0.5}}, {rng.uniform(0, 3):.6f}}} {{ Volume{{{i}}}; }}")
    joined = rng.choice(("BooleanFragments", "BooleanFragments", "BooleanUnion", "BooleanDifference"))
    lines.append(f"{joined}{{ Volume{{1}}; Delete; }}{{ Volume{{2:{count}}}; Delete; }}")
    size = rng.uniform(0.06, 0.2)
    lines.append(f"Mesh.MeshSizeMin = {size / rng.choice((1, 1, 4)):.6f}; Mesh.MeshSizeMax = {size:.6f}; "
                 f"Mesh.MeshSizeFromCurvature = {rng.choice((0, 0, 12))}; Mesh.Algorithm3D = 1;")
    (folder / "m.geo").write_text("\n".join(lines) + "\n")
    try:
        subprocess.run(["gmsh", "-3", "-format", "mesh", "-o", "m.mesh", "m.geo"], cwd=folder, capture_output=True,
                       timeout=MESHER_SECONDS, check=True)
        return medit.read(folder / "m.mesh")
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired, FileNotFoundError):
        return None


FAMILIES = (star, shells, lattice, plate, solid)
SMALLEST, LARGEST = 1000, 50000  # tetrahedra
ATTEMPTS = 20


def make(seed, rng, folder):
    """The mesh of a seed and the name of its family. Shapes that cannot be meshed, or not in 1 k to 50 k tetrahedra, are drawn
    again, so that every seed gives one; None after ATTEMPTS."""
    family = FAMILIES[seed % len(FAMILIES)]
    for attempt in range(ATTEMPTS):
        place = folder / str(attempt)
        place.mkdir()
        mesh = family(rng, place)
        if mesh and SMALLEST <= len(mesh.get("Tetrahedra", ())) <= LARGEST:
            return medit.positive(mesh), family.__name__
    return None, family.__name__


def freeze(mesh, rng):
    """Freezes something at random: adds lists to the mesh; returns words for the command line and the vertices that must not move."""
    points, tets = mesh["Vertices"], mesh["Tetrahedra"]
    tags = numpy.unique(tets[:, 4])
    kind = rng.choice(("nothing", "vertices", "triangles", "region") if len(tags) > 1 else ("nothing", "vertices", "triangles"))
    some = numpy.random.default_rng(rng.randrange(2**32))
    if kind == "vertices":
        mesh["RequiredVertices"] = numpy.flatnonzero(some.random(len(points)) < 0.05)[:, None]
        return [], mesh["RequiredVertices"].ravel()
    if kind == "triangles":
        faces = medit.skin(tets)
        faces = faces[some.random(len(faces)) < 0.05]
        listed = mesh.get("Triangles", numpy.empty((0, 4), int))
        mesh["Triangles"] = numpy.concatenate([listed, numpy.column_stack([faces, numpy.zeros(len(faces), int)])])
        mesh["RequiredTriangles"] = numpy.arange(len(listed), len(listed) + len(faces))[:, None]
        return [], numpy.unique(faces)
    if kind == "region":
        tag = rng.choice(tags.tolist())
        return ["--freeze", f"tag={tag}"], numpy.unique(tets[tets[:, 4] == tag, :4])
    return [], numpy.empty(0, int)


def tangle(mesh, rng, boundary):
    """Displaces vertices at random, by as much of their edges as inverts up to 5 % of the tetrahedra: inner ones, with `boundary`
    also those of the surface and of interfaces, within their planes and lines and with no face there turned over. Returns the mesh, or
    None where nothing inverts."""
    points, tets = mesh["Vertices"][:, :3], mesh["Tetrahedra"]
    some = numpy.random.default_rng(rng.randrange(2**32))
    faces = medit.skin(tets)
    normals = numpy.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    sizes = numpy.linalg.norm(normals, axis=1)
    normals /= sizes[:, None]
    spread = numpy.zeros((len(points), 3, 3))
    for k in range(3):
        numpy.add.at(spread, faces[:, k], normals[:, :, None] * normals[:, None, :])
    values, ways = numpy.linalg.eigh(spread)
    if boundary:
        allowed = values < 1e-12  # ways in which no plane of the surface is left
    else:
        allowed = numpy.repeat(~numpy.isin(numpy.arange(len(points)), faces)[:, None], 3, axis=1)
    for name in ("Corners", "RequiredVertices"):
        allowed[mesh.get(name, numpy.empty((0, 1), int))[:, 0]] = False
    allowed[mesh.get("Edges", numpy.empty((0, 3), int))[:, :2].ravel()] = False
    lengths, counts = numpy.zeros(len(points)), numpy.zeros(len(points))
    for a, b in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)):
        length = numpy.linalg.norm(points[tets[:, a]] - points[tets[:, b]], axis=1)
        for k in (a, b):
            numpy.add.at(lengths, tets[:, k], length)
            numpy.add.at(counts, tets[:, k], 1)
    way = some.normal(size=points.shape)
    way *= (some.random(len(points)) * lengths / numpy.maximum(counts, 1) / numpy.linalg.norm(way, axis=1))[:, None]
    way = numpy.einsum("nik,nk,njk,nj->ni", ways, allowed.astype(float), ways, way)
    def displaced(share):
        offset = share * way
        for _ in range(60):
            moved = points + offset
            now = numpy.cross(moved[faces[:, 1]] - moved[faces[:, 0]], moved[faces[:, 2]] - moved[faces[:, 0]])
            turned = (now * normals).sum(axis=1) <= 0.1 * sizes
            if not turned.any():
                return moved
            offset[numpy.unique(faces[turned])] *= 0.7
        return points

    target, low, high = some.uniform(0.005, 0.05), 0, 3
    for _ in range(20):
        middle = (low + high) / 2
        bad = (medit.volumes(displaced(middle), tets) <= 0).mean()
        low, high = (low, middle) if bad > target else (middle, high)
    moved = displaced(low)
    if (medit.volumes(moved, tets) <= 0).sum() == 0:
        return None
    return {**mesh, "Vertices": numpy.column_stack([moved, mesh["Vertices"][:, 3]])}
