# SPDX-License-Identifier: Apache-2.0
"""Sect. 5.2 of the paper: many meshes, and on each: no inversion, no broken face, boundary vertices on the input surface.

The meshes are TetGen's, its optimizer off, of random star-shaped polyhedra: noisy spheres of flat facets, some with a cavity, some
squashed to plates, some needles; most have 1 k to 20 k tetrahedra. Seeds are 1 to N."""

import json
import math
import pathlib
import random
import subprocess
import tempfile

import harness


def icosphere(levels):
    t = (1 + math.sqrt(5)) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t), (t, 0, -1),
              (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
             (9, 8, 1)]
    points = [tuple(c / math.dist(p, (0, 0, 0)) for c in p) for p in points]
    for _ in range(levels):
        middle, finer = {}, []
        for a, b, c in faces:
            ids = []
            for edge in ((a, b), (b, c), (c, a)):
                key = tuple(sorted(edge))
                if key not in middle:
                    m = [sum(x) / 2 for x in zip(points[edge[0]], points[edge[1]])]
                    length = math.dist(m, (0, 0, 0))
                    middle[key] = len(points)
                    points.append(tuple(x / length for x in m))
                ids.append(middle[key])
            finer += [(a, ids[0], ids[2]), (b, ids[1], ids[0]), (c, ids[2], ids[1]), tuple(ids)]
        faces = finer
    return points, faces


def polyhedron(rng):
    """Points and triangles of a random closed surface around the origin, and whether it has a hole at the origin."""
    shape = rng.choice(((1, 1, 1), (1, 1, 0.1), (1, 0.3, 0.3), (1, 0.5, 0.05), (1, 1, 0.02)))
    points, faces = icosphere(rng.choice((1, 2, 2) if min(shape) >= 0.3 else (1, 1, 1, 2)))  # fine plates have too many
    noise = rng.choice((0, 0.1, 0.3, 0.5))
    waves = [(rng.uniform(1, 5), [rng.uniform(-1, 1) for _ in range(3)], rng.uniform(0, 6)) for _ in range(3)]
    moved = []
    for p in points:
        r = 1 + noise * (rng.random() - 0.5)
        r += 0.1 * sum(math.sin(f * sum(a * b for a, b in zip(d, p)) + s) for f, d, s in waves)
        moved.append([r * x * s for x, s in zip(p, shape)])
    hollow = rng.random() < 0.3
    if hollow:
        n = len(moved)
        moved += [[0.4 * x for x in p] for p in moved]
        faces = faces + [(a + n, c + n, b + n) for a, b, c in faces]
    return moved, faces, hollow


def make_mesh(seed, folder):
    rng = random.Random(seed)
    points, faces, hollow = polyhedron(rng)
    lines = [f"{len(points)} 3 0 0"] + [f"{i + 1} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(points)]
    lines += [f"{len(faces)} 0"] + [f"3 {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    lines += ["1", "1 0 0 0"] if hollow else ["0"]
    (folder / "m.smesh").write_text("\n".join(lines + ["0"]) + "\n")
    extent = math.prod(max(p[k] for p in points) - min(p[k] for p in points) for k in range(3))
    volume = extent / rng.choice((500, 2000, 8000))
    command = ["tetgen", f"-pq1.4a{volume:.12f}O0/0gz", "m.smesh"]
    try:
        subprocess.run(command, cwd=folder, capture_output=True, timeout=120, check=True)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
        return None
    mesh = folder / "m.1.mesh"
    return mesh if mesh.exists() else None


def measure(seed, boundary):
    """One mesh: None if TetGen fails, else the result."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        mesh = make_mesh(seed, folder)
        if mesh is None:
            return None
        result = folder / "out.meshb"
        record = harness.run([harness.TETUNE, "optimize", mesh, "-o", result, "--quiet", "--boundary", boundary], timeout=300)
        if record["code"] != 0:
            return {"problem": record["output"].strip()[:200] or "ran out of time"}
        c = harness.compare(mesh, result)
        before, after, change = c["before"], c["after"], c["change"]
        return {"problem": None if after["validity"]["valid"] else str(after["validity"]["findings"]),
                "tets": before["quality"]["tetrahedra"], "vertices_to_old": change["distance_vertices_to_old"],
                "new_to_old": change["distance_new_to_old"], "seconds": record["seconds"],
                "angle_before": before["quality"]["dihedral_min_deg"], "angle_after": after["quality"]["dihedral_min_deg"]}


def run(args):
    """Prints the table, keeps robustness-BOUNDARY.json and returns the exit code: 0 if there was no failure."""
    path = args.out / f"robustness-{args.boundary}.json"
    data = json.loads(path.read_text()) if args.resume and path.exists() else {"provenance": harness.provenance(), "seeds": {}}
    seeds = data["seeds"]
    for seed in range(1, args.robustness + 1):
        if str(seed) not in seeds:
            seeds[str(seed)] = measure(seed, args.boundary)
            if seed % 10 == 0 or seed == args.robustness:
                harness.write_json(path, data)
    made = {seed: r for seed, r in seeds.items() if r}
    problems = {seed: r["problem"] for seed, r in made.items() if r["problem"]}
    judged = {seed: r for seed, r in made.items() if "tets" in r}
    near = sum(r["vertices_to_old"] < 1e-3 for r in judged.values())
    sizes = sorted(r["tets"] for r in judged.values()) or [0]
    print(f"`--boundary {args.boundary}`, {sizes[0]} to {sizes[-1]} tetrahedra, middle {sizes[len(sizes) // 2]}; "
          f"{sum(r['seconds'] for r in judged.values()):.0f} s in tetune\n")
    print(f"| | ours | paper |\n|---|---|---|\n| meshes | {len(made)} (TetGen made none for {len(seeds) - len(made)} seeds more) "
          "| 10,000 |")
    print(f"| inverted, broken or refused | {len(problems)} | 0 |")
    print(f"| boundary vertices within 1e-3 of a mean boundary edge of the input surface "
          f"| {100 * near / max(1, len(made)):.2f} % | 99.95 % |")
    print(f"| largest such distance | {max((r['vertices_to_old'] for r in judged.values()), default=0):.2e} | 0.19 |")
    print(f"| the same from points within the new triangles | {max((r['new_to_old'] for r in judged.values()), default=0):.2e} | - |")
    lower = {seed: r["angle_before"] - r["angle_after"] for seed, r in judged.items() if r["angle_after"] < r["angle_before"]}
    print(f"| smallest angle lower than before | {len(lower)} | - |")
    for seed, text in problems.items():
        print(f"seed {seed}: {text}")
    for seed, loss in sorted(lower.items(), key=lambda item: -item[1])[:10]:
        print(f"seed {seed}: smallest angle {loss:.3f} degrees lower")
    return 0 if not problems and near >= 0.9995 * len(made) else 1
