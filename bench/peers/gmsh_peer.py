# SPDX-License-Identifier: Apache-2.0
"""Runs Gmsh as an optimizer and for its measures, each call in a separate process, as Gmsh may crash.

  gmsh_peer.py probe                                    version, and whether it can optimize an existing mesh by HXT
  gmsh_peer.py optimize IN OUT THRESHOLD METHOD [...]   METHOD: default, Netgen, HXT; one after the other
  gmsh_peer.py quality FILE                             smallest signed inverse condition number
The last line printed is JSON."""

import json
import os
import sys
import time

import gmsh
import numpy


def tetrahedra(volume):
    return gmsh.model.mesh.getElementsByType(4, volume)[0]


def volumes():
    return [tag for _, tag in gmsh.model.getEntities(3)]


def netgen():
    """Gmsh appends Netgen's tetrahedra to the volume's and leaves the old ones, first in the list, to the caller."""
    before = {volume: len(tetrahedra(volume)) for volume in volumes()}
    gmsh.model.mesh.optimize("Netgen", force=True)
    for volume, count in before.items():
        now = tetrahedra(volume)
        if len(now) > count:
            gmsh.model.mesh.removeElements(3, volume, now[:count])


def face_keys(triangles):
    """A number per triangle, independent of the order of its vertices; unique up to 2.6 million vertices."""
    n, base = numpy.sort(triangles.astype(numpy.uint64), axis=1), numpy.uint64(2642245)
    return (n[:, 0] * base + n[:, 1]) * base + n[:, 2]


def add_surfaces_to_volumes():
    """Netgen requires the surfaces of each volume, which a MEDIT file does not have, and crashes without. createTopology()
    finds them, but refuses or hangs on lines that meet freely, and renumbers lines. So each volume is replaced by one
    with the same elements and its surfaces."""
    mesh = gmsh.model.mesh
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    if not surfaces:
        mesh.createTopology()
        return
    keys = [face_keys(mesh.getElementsByType(2, surface)[1].reshape(-1, 3)) for surface in surfaces]
    owner, keys = numpy.repeat(surfaces, [len(k) for k in keys]), numpy.concatenate(keys)
    order = numpy.argsort(keys)
    owner, keys = owner[order], keys[order]
    described = []
    for volume in volumes():
        elements, nodes = mesh.getElementsByType(4, volume)
        corners = nodes.reshape(-1, 4)
        faces = numpy.concatenate([face_keys(numpy.delete(corners, k, axis=1)) for k in range(4)])
        place = numpy.minimum(numpy.searchsorted(keys, faces), len(keys) - 1)
        bounds = numpy.unique(owner[place[keys[place] == faces]])
        described.append((volume, bounds.tolist(), elements, nodes, *mesh.getNodes(3, volume)[:2]))
    gmsh.model.removeEntities(gmsh.model.getEntities(3))
    for volume, bounds, _, _, node_tags, coordinates in described:
        gmsh.model.addDiscreteEntity(3, volume, bounds)
        mesh.addNodes(3, volume, node_tags, coordinates)
    for volume, _, elements, nodes, _, _ in described:
        mesh.addElementsByType(volume, 4, elements, nodes)


def optimize(source, target, threshold, methods):
    gmsh.option.setNumber("Mesh.OptimizeThreshold", float(threshold))
    if "HXT" in methods:
        gmsh.option.setNumber("General.NumThreads", os.cpu_count())
    gmsh.open(source)
    if "Netgen" in methods:
        add_surfaces_to_volumes()
    start = time.perf_counter()
    for method in methods:
        if method == "Netgen":
            netgen()
        else:
            gmsh.model.mesh.optimize("" if method == "default" else method, force=True)
    seconds = time.perf_counter() - start
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write(target)
    return {"seconds": seconds}


def quality(source):
    gmsh.open(source)
    least, most = float("inf"), float("-inf")
    for volume in volumes():
        values = gmsh.model.mesh.getElementQualities(tetrahedra(volume), "minSICN")
        least, most = min(least, min(values)), max(most, max(values))
    return {"min_sicn": least if most > 0 else -most}  # all listed inside out: of the same mesh the right way round


def probe():
    gmsh.model.add("probe")
    try:
        gmsh.model.mesh.optimize("HXT", force=True)
        hxt = True
    except Exception:
        hxt = False
    return {"version": gmsh.option.getString("General.Version"), "hxt": hxt}


gmsh.initialize(readConfigFiles=False, interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
if sys.argv[1] == "optimize":
    result = optimize(sys.argv[2], sys.argv[3], sys.argv[4], sys.argv[5:])
else:
    result = {"quality": quality, "probe": probe}[sys.argv[1]](*sys.argv[2:])
print(json.dumps(result))
gmsh.finalize()
