# SPDX-License-Identifier: Apache-2.0
"""The plugin for VTK's files of a package that was built without VTK, as wheels are: by pyvista or meshio.

libexec/tetune/tetune-vtk starts this file; src/io/plugin/plugin_protocol.hpp defines what it exchanges with the library."""

from __future__ import annotations

import ctypes
import fcntl
import os
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

# The package's own folder is on the path of an isolated interpreter only if it is that of the interpreter.
sys.path.append(str(Path(__file__).resolve().parents[1]))

from tetune._vtk_stream import CELLS, VERSION, Grid, Reader, Refused, Writer, decode, encode  # noqa: E402

DESCRIPTOR = 3
# The most characters of a name that VTK's reader of legacy files accepts.
LEGACY_NAME = 255


# ---- The library that reads and writes files.


def package() -> str:
    for name in ("pyvista", "meshio"):
        try:
            __import__(name)
        except ImportError:
            continue
        return name
    raise Refused("files of VTK need pyvista or meshio where tetune is installed: pip install meshio")


def check(file: str) -> str:
    name, ending = package(), Path(file).suffix.lower()
    if ending not in (".vtu", ".vtk", ".pvtu"):
        raise Refused(f"files with the extension \"{ending}\" need a tetune that was built with VTK, which wheels are not; "
                      "convert the mesh to .vtu, .msh or .mesh first")
    if ending == ".pvtu" and name != "pyvista":
        raise Refused("files in parts need pyvista: pip install pyvista")
    return name


def load(file: str, warnings: list[str]) -> Grid:
    return without_ghosts(load_all(file, warnings))


def without_ghosts(grid: Grid) -> Grid:
    """Ghost cells are copies of the elements of another part."""
    if "vtkGhostType" not in grid.cell_data:
        return grid
    kept = (np.asarray(grid.cell_data["vtkGhostType"]).astype(int) & 1) == 0
    number = np.cumsum(kept) - 1
    cells = [(kind, ids[kept[rows]], number[rows[kept[rows]]]) for kind, ids, rows in grid.cells]
    return Grid(grid.points, [block for block in cells if len(block[2])], grid.point_data,
                {name: np.asarray(values)[kept] for name, values in grid.cell_data.items()})


@contextmanager
def kinds_of_meshio() -> Iterator[None]:
    """Names the kinds of cells that meshio lacks."""
    try:
        yield
    except KeyError as e:
        if e.args[:1] not in (("wedge15",), ("pyramid13",)):
            raise
        raise Refused(f"meshio has no cells of type {e.args[0]}; install pyvista, which has them") from None


def load_all(file: str, warnings: list[str]) -> Grid:
    if check(file) == "pyvista":
        return load_by_pyvista(file, warnings)
    import meshio

    with kinds_of_meshio():
        mesh = meshio.read(file)
    warn_of_field_data(mesh.field_data, warnings)
    numbers = {name: number for number, (_, name) in CELLS.items()}
    cells, first = [], 0
    for block in mesh.cells:
        if block.type not in numbers:
            raise Refused(f"cells of type {block.type} are not supported")
        cells.append((numbers[block.type], np.asarray(block.data), np.arange(first, first + len(block.data))))
        first += len(block.data)
    points = np.asarray(mesh.points, float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise Refused("the points do not have three coordinates")
    return Grid(points, cells, dict(mesh.point_data),
                {name: np.concatenate([np.asarray(v) for v in values]) for name, values in mesh.cell_data.items()})


def warn_of_field_data(names: Iterable[str], warnings: list[str]) -> None:
    warnings += [f'the field data "{name}" is not kept' for name in names]


def load_by_pyvista(file: str, warnings: list[str]) -> Grid:
    import pyvista as pv

    grid = pv.read(file)
    if file.endswith(".pvtu"):
        grid = pv.wrap(grid).clean()
    if not isinstance(grid, pv.UnstructuredGrid):
        raise Refused(f"it holds a {type(grid).__name__}, not an unstructured grid")
    warn_of_field_data(grid.field_data.keys(), warnings)
    # By VTK, as the name of the offsets in pyvista depends on its version.
    offsets = np.asarray(pv.convert_array(grid.GetCells().GetOffsetsArray()))
    kinds, ids = np.asarray(grid.celltypes), np.asarray(grid.cell_connectivity)
    cells = []
    for kind in np.unique(kinds):
        if kind not in CELLS:
            raise Refused(f"cells of VTK's type {kind} are not supported")
        rows, size = np.flatnonzero(kinds == kind), CELLS[kind][0]
        if (np.diff(offsets)[rows] != size).any():
            raise Refused(f"cells of VTK's type {kind} do not all have {size} points")
        cells.append((int(kind), ids[offsets[rows][:, None] + np.arange(size)], rows))
    return Grid(np.asarray(grid.points, float), cells, {n: np.asarray(v) for n, v in grid.point_data.items()},
                {n: np.asarray(v) for n, v in grid.cell_data.items()})


def written_length(name: str) -> int:
    """The number of characters in a legacy file, where VTK writes %XX for blanks and bytes that are not ASCII."""
    return sum(3 if b < 33 or b > 126 or b in b'"%' else 1 for b in name.encode())


def start_of(name: str, most: int) -> str:
    """The longest start of a name that has at most `most` characters in a legacy file."""
    lengths = np.cumsum([written_length(c) for c in name])
    return name[: np.searchsorted(lengths, most, side="right")]


def with_short_names(grid: Grid, warnings: list[str]) -> Grid:
    """Replaces names of data that are too long for legacy files by shorter ones, each different from all others."""
    names = dict.fromkeys([*grid.point_data, *grid.cell_data])
    short = {name: name for name in names if written_length(name) <= LEGACY_NAME}
    for name in names:
        if name in short:
            continue
        chosen, number = start_of(name, LEGACY_NAME), 2
        while chosen in names or chosen in short.values():
            end = f"~{number}"
            chosen, number = start_of(name, LEGACY_NAME - len(end)) + end, number + 1
        short[name] = chosen
        warnings.append(f'the name of the data "{name}" is longer than the format allows; it is shortened to "{chosen}"')
    return grid._replace(point_data={short[name]: values for name, values in grid.point_data.items()},
                         cell_data={short[name]: values for name, values in grid.cell_data.items()})


def save(file: str, grid: Grid, warnings: list[str]) -> None:
    """Writes cells in their order; `rows` are not used."""
    if file.endswith(".vtk"):
        grid = with_short_names(grid, warnings)
    if check(file) == "pyvista":
        import pyvista as pv

        flat = [np.insert(ids, 0, ids.shape[1], axis=1).ravel() for _, ids, _ in grid.cells]
        kinds = [np.full(len(ids), kind, np.uint8) for kind, ids, _ in grid.cells]
        out = pv.UnstructuredGrid(np.concatenate(flat), np.concatenate(kinds), grid.points)
        for name, values in grid.point_data.items():
            out.point_data[name] = values
        for name, values in grid.cell_data.items():
            out.cell_data[name] = values
        out.save(file)
        return
    import meshio

    ends = np.cumsum([len(ids) for _, ids, _ in grid.cells])[:-1]
    blocks = [(CELLS[kind][1], ids) for kind, ids, _ in grid.cells]
    # Legacy files of meshio name short integers by types that VTK does not know.
    short = ("i1", "i2", "u2") if file.endswith(".vtk") else ()
    plain = lambda values: values.astype("i4") if values.dtype.str[1:] in short else values
    data = {name: np.split(plain(values), ends) for name, values in grid.cell_data.items()}
    with kinds_of_meshio():
        meshio.Mesh(grid.points, blocks, {n: plain(v) for n, v in grid.point_data.items()}, data).write(file)


# ---- The program.


def answer(out: Writer) -> None:
    os.ftruncate(DESCRIPTOR, 0)
    os.lseek(DESCRIPTOR, 0, os.SEEK_SET)
    with os.fdopen(DESCRIPTOR, "wb", closefd=False) as channel:
        channel.writelines(out.parts)


def run(verb: str, file: str) -> Writer:
    warnings: list[str] = []
    mesh = Writer()
    error = ""
    try:
        if verb == "read":
            encode(load(file, warnings), warnings, mesh)
        elif verb == "check":
            check(file)
        elif verb == "times":
            raise Refused("only the programs of a build with VTK read the times of Exodus files")
        else:
            stream = Reader(read_all())
            if stream.number("Q") != VERSION:
                raise Refused("the plugin is of another build; install tetune again")
            save(file, decode(stream, warnings), warnings)
    except Refused as e:
        error = str(e)
    except MemoryError:
        error = "there is not enough memory for it"
    except (Exception, SystemExit) as e:  # of the package: the file is damaged, or of a kind that it does not know
        text = "".join(c if " " <= c <= "~" else "?" for c in f"{type(e).__name__}: {e}")
        error = f"{package()} failed to {verb} it ({text[:300]})"
    out = Writer()
    out.number("Q", VERSION ^ 0xFFFF_FFFF_FFFF_FFFF)
    out.text(error)
    out.number("Q", 0 if error else len(warnings))
    for warning in [] if error else warnings:
        out.text(warning)
    if not error:
        out.parts += mesh.parts
    return out


def read_all() -> bytes:
    os.lseek(DESCRIPTOR, 0, os.SEEK_SET)
    with os.fdopen(DESCRIPTOR, "rb", closefd=False) as channel:
        return channel.read()


def end_with_parent(written: str | None) -> None:
    """An interrupt from the terminal is for tetune. When tetune ends, this process ends and leaves no half-written file."""
    parent = fcntl.fcntl(DESCRIPTOR, fcntl.F_GETOWN)

    def end(*_: object) -> None:
        if os.getppid() == parent:
            return
        if written is not None and os.path.exists(written):
            os.unlink(written)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, end)
    PR_SET_PDEATHSIG = 1
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGTERM))
    end()  # there is no signal where tetune has ended already


if __name__ == "__main__":
    end_with_parent(sys.argv[2] if sys.argv[1] == "write" else None)
    answer(run(sys.argv[1], sys.argv[2]))
