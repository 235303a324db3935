# SPDX-License-Identifier: Apache-2.0
"""The shapes with few corners: large plane facets and nothing else, so that most boundary vertices may slide."""

import math

from surface import Surface, circle


def revolve(surface, profile, n):
    """Turns a profile (r, z), level where it meets the axis, into n plane staves a band. Returns the facets of each band;
    a level band is a single facet."""
    rings = [[surface.point(x, y, z) for x, y in circle(n, r)] if r > 0 else [] for r, z in profile]
    bands = []
    for (r0, z0), (r1, z1), lower, upper in zip(profile, profile[1:], rings, rings[1:]):
        if z0 == z1:
            outline, inner = (lower, upper) if r0 > r1 else (upper, lower)
            bands.append([surface.facet(outline, [inner] if inner else [])])
        else:
            bands.append([surface.facet([lower[k], lower[(k + 1) % n], upper[(k + 1) % n], upper[k]]) for k in range(n)])
    return bands


def emboss(surface, facet, n, radius, height, taper=1.0, along=0.0):
    """On the middle of a facet whose outline is a trapezium, moved by `along` towards its upper edge: a prism of n sides,
    outwards where height > 0, a pit where it is below; with taper 0 a leaning pyramid."""
    loops, holes = surface.facets[facet]
    a, b, c, d = (surface.points[i] for i in loops[0])
    low, high = ([(p[k] + q[k]) / 2 for k in range(3)] for p, q in ((a, b), (d, c)))
    u, v = unit([b[k] - a[k] for k in range(3)]), unit([high[k] - low[k] for k in range(3)])
    normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    middle = [(low[k] + high[k]) / 2 + along * v[k] for k in range(3)]

    def ring(scale, lift):
        return [surface.point(*(middle[k] + scale * (x * u[k] + y * v[k]) + lift * normal[k] for k in range(3)))
                for x, y in circle(n, radius)]

    base = ring(1.0, 0.0)
    loops.append(base)
    holes.append(tuple(middle))
    if taper == 0:
        tip = surface.point(*(middle[k] + height * normal[k] + radius * (0.3 * u[k] - 0.5 * v[k]) for k in range(3)))
        for k in range(n):
            surface.facet([base[k], base[(k + 1) % n], tip])
        return
    top = ring(taper, height)
    for k in range(n):
        surface.facet([base[k], base[(k + 1) % n], top[(k + 1) % n], top[k]])
    surface.facet(top)


def unit(v):
    length = math.hypot(*v)
    return [x / length for x in v]


def cube():
    s = Surface()
    wall(s, [(0, 0), (1, 0), (1, 1), (0, 1)], 0, 1)
    for z in (0, 1):
        s.facet(level(s, [(0, 0), (1, 0), (1, 1), (0, 1)], z))
    return s


def barrel():
    """Sixteen plane staves in five bands, three pairs of hoops, both heads recessed, a bung hole."""
    s = Surface()
    half = [(0, 0.08), (0.70, 0.08), (0.70, 0), (0.78, 0), (0.80, 0.12), (0.84, 0.12), (0.88, 0.28), (0.84, 0.28),
            (0.92, 0.56), (0.96, 0.56), (0.98, 0.70), (0.94, 0.70), (1.0, 1.08)]
    profile = half + [(r, 2.37 - 0.96 * z) for r, z in reversed(half)]
    bands = revolve(s, profile, 16)
    emboss(s, bands[12][0], 8, 0.09, -0.25)
    return s.skewed()


def snowman():
    """Three stacked balls of ten flat sides, hat, nose, eyes, buttons."""
    s = Surface()
    profile = [(0, 0), (0.62, 0), (0.95, 0.38), (1.0, 0.80), (0.80, 1.22),  # belly
               (0.48, 1.42), (0.70, 1.66), (0.74, 1.98), (0.58, 2.26),  # chest
               (0.32, 2.40), (0.48, 2.56), (0.52, 2.84), (0.44, 3.02),  # head
               (0.68, 3.02), (0.68, 3.10), (0.40, 3.10), (0.36, 3.56), (0, 3.56)]  # hat
    bands = revolve(s, profile, 10)
    emboss(s, bands[10][0], 6, 0.06, 0.34, taper=0)
    for k in (9, 1):
        emboss(s, bands[10][k], 6, 0.05, -0.05, along=0.05)
    for band in (2, 3, 6, 7):
        emboss(s, bands[band][0], 6, 0.07, 0.05, taper=0.7)
    return s.skewed()


def wall(s, outline, z0, z1, outline1=None):
    """The sides of a prism, or between two outlines with as many points; returns its facets."""
    low, high = level(s, outline, z0), level(s, outline1 or outline, z1)
    n = len(low)
    return [s.facet([low[k], low[(k + 1) % n], high[(k + 1) % n], high[k]]) for k in range(n)]


def level(s, outline, z):
    return [s.point(x, y, z) for x, y in outline]


def part():
    """A flange: plate with counterbored bolt holes, two pockets and a lug, a boss with a stepped bore, drilled sides."""
    s = Surface()
    x, y, c = 1.5, 1.0, 0.25
    plate = [(-x + c, -y), (x - c, -y), (x, -y + c), (x, -0.35), (x + 0.45, -0.22), (x + 0.45, 0.22), (x, 0.35), (x, y - c),
             (x - c, y), (-x + c, y), (-x, y - c), (-x, -y + c)]
    corners = [(sx * 1.2, sy * 0.7) for sx in (-1, 1) for sy in (-1, 1)]
    bolts = [circle(12, 0.11, *p) for p in corners]
    sinks = [circle(12, 0.19, *p) for p in corners]
    pockets = [[(p + a * 0.12, q + b * 0.34) for a, b in ((-1, -0.7), (-0.5, -1), (0.5, -1), (1, -0.7), (1, 0.7),
                                                         (0.5, 1), (-0.5, 1), (-1, 0.7))] for p, q in ((-0.88, 0), (0.88, 0))]
    eye = circle(12, 0.12, x + 0.2, 0.0)
    bore, step = circle(24, 0.30), circle(24, 0.42)
    boss, chamfer = circle(24, 0.62), circle(24, 0.55)

    s.facet(level(s, plate, 0), [level(s, o, 0) for o in (*bolts, eye, step)])
    sides = wall(s, plate, 0, 0.36)
    s.facet(level(s, plate, 0.36), [level(s, o, 0.36) for o in (*sinks, *pockets, eye, boss)])
    wall(s, eye, 0, 0.36)
    for bolt, sink in zip(bolts, sinks):
        wall(s, bolt, 0, 0.22)
        s.facet(level(s, sink, 0.22), [level(s, bolt, 0.22)])
        wall(s, sink, 0.22, 0.36)
    for pocket in pockets:
        s.facet(level(s, pocket, 0.18))
        wall(s, pocket, 0.18, 0.36)
    wall(s, step, 0, 0.14)
    s.facet(level(s, step, 0.14), [level(s, bore, 0.14)])
    wall(s, bore, 0.14, 1.16)
    wall(s, boss, 0.36, 1.08)
    wall(s, boss, 1.08, 1.16, chamfer)
    s.facet(level(s, chamfer, 1.16), [level(s, bore, 1.16)])
    for side in (0, 8):
        emboss(s, sides[side], 8, 0.07, -0.2)
    return s.skewed()
