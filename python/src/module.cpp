// SPDX-License-Identifier: Apache-2.0
// tetune._core: the library's types and functions as they are. What Python adds is in python/tetune/*.py.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>

#include "arrays.hpp"
#include "options.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

using Self = nb::handle_t<TetMesh>;
using Block = std::tuple<std::string, nb::object>;

TetMesh& of(Self self) { return nb::cast<TetMesh&>(self); }

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw nb::python_error();
}

void fill_tags(std::vector<int>& tags, std::size_t size) {
  if (tags.empty()) tags.resize(size, 0);
}

void construct(TetMesh* place, nb::object points, nb::object tets, nb::object point_tags, nb::object tet_tags,
               nb::object triangles, nb::object triangle_tags, nb::object edges, nb::object edge_tags,
               nb::object corners, nb::object required_vertices, nb::object ridges, nb::object required_edges,
               nb::object required_triangles, nb::object required_tets, const std::vector<Block>& others) {
  TetMesh mesh;
  assign("points", points, mesh.points);
  assign("tets", tets, mesh.tets);
  assign("point_tags", point_tags, mesh.point_tags);
  assign("tet_tags", tet_tags, mesh.tet_tags);
  assign("triangles", triangles, mesh.triangles);
  assign("triangle_tags", triangle_tags, mesh.triangle_tags);
  assign("edges", edges, mesh.edges);
  assign("edge_tags", edge_tags, mesh.edge_tags);
  assign("corners", corners, mesh.corners);
  assign("required_vertices", required_vertices, mesh.required_vertices);
  assign("ridges", ridges, mesh.ridges);
  assign("required_edges", required_edges, mesh.required_edges);
  assign("required_triangles", required_triangles, mesh.required_triangles);
  assign("required_tets", required_tets, mesh.required_tets);
  for (const auto& [kind, object] : others) {
    const auto array = as_array(kind.c_str(), object);
    if (array.ndim() != 2) throw nb::value_error((kind + " must have the shape (n, vertices of one)").c_str());
    ElementBlock block{
        kind, static_cast<int>(array.shape(1)), std::vector<Index>(array.size()), std::vector<int>(array.shape(0)), {}};
    if (array.size() > 0) copy_array(kind.c_str(), array, array.shape(1), block.element2vertex.data());
    mesh.others.push_back(std::move(block));
  }
  fill_tags(mesh.point_tags, mesh.points.size());
  fill_tags(mesh.tet_tags, mesh.tets.size());
  fill_tags(mesh.triangle_tags, mesh.triangles.size());
  fill_tags(mesh.edge_tags, mesh.edges.size());
  const std::int64_t turned = [&mesh] {
    const nb::gil_scoped_release release;
    return orient_uniformly(mesh);
  }();
  if (turned > 0 && !mesh.listed_inside_out) {
    warn(std::to_string(turned) + " tetrahedra were listed inside out, unlike their neighbours: they are turned");
  }
  new (place) TetMesh(std::move(mesh));
}

/// Calls back with the GIL held, after Python's own handlers of signals (Ctrl-C) have run.
Context context_of(nb::object progress) {
  Context context;
  context.progress = [progress](const Progress& p) {
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (progress.is_none()) return true;
    const nb::object answer = progress(p);
    return answer.is_none() || nb::cast<bool>(nb::bool_(answer));
  };
  // Between calls of the above as well: passes over a large mesh take seconds.
  context.stop = [] {
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return false;
  };
  return context;
}

Report improve(TetMesh& mesh, const nb::dict& options, nb::object progress) {
  const Options parsed = parse_options(options);
  const Context context = context_of(std::move(progress));
  const nb::gil_scoped_release release;
  return optimize(mesh, parsed, context);
}

/// Frees what an array of numpy's shows, once nobody has it any more.
template <class T>
nb::capsule owner_of(std::vector<T>* values) {
  return {values, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); }};
}

nb::dict measures_by_name(const TetMesh& mesh, int threads) {
  std::array<std::vector<double>, kMeasures> columns;
  {
    const nb::gil_scoped_release release;
    const std::vector<Measures> each = measure_each(mesh, threads);
    for (std::size_t k = 0; k < kMeasures; ++k) {
      columns[k].resize(each.size());
      for (std::size_t t = 0; t < each.size(); ++t) columns[k][t] = each[t][k];
    }
  }
  nb::dict result;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    auto* column = new std::vector<double>(std::move(columns[k]));
    const nb::capsule owner = owner_of(column);
    result[to_string(static_cast<Measure>(k))] = nb::cast(view(*column, owner));
  }
  return result;
}

/// Entry after entry, of the types that carry_point_data() means, and of rows.
using Entries = nb::ndarray<nb::ro, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

DataArray data_array(const Entries& from) {
  DataArray array{"", static_cast<int>(from.shape(1)), {}};
  const auto copy = [&]<class T>(T) {
    const T* data = static_cast<const T*>(from.data());
    array.values = std::vector<T>(data, data + from.size());
  };
  if (from.dtype() == nb::dtype<double>()) {
    copy(double{});
  } else if (from.dtype() == nb::dtype<float>()) {
    copy(float{});
  } else if (from.dtype() == nb::dtype<std::int32_t>()) {
    copy(std::int32_t{});
  } else {
    throw nb::type_error("point data must be float64, float32 or int32");
  }
  return array;
}

/// The array's memory as one of numpy's of the shape (entries, components).
nb::object numpy_array(DataArray&& array) {
  return std::visit(
      [&array]<class T>(std::vector<T>& values) {
        auto* kept = new std::vector<T>(std::move(values));
        const nb::capsule owner = owner_of(kept);
        const auto components = static_cast<std::size_t>(array.components);
        return nb::cast(
            nb::ndarray<nb::numpy, T, nb::ndim<2>>(kept->data(), {kept->size() / components, components}, owner));
      },
      array.values);
}

nb::list carry(const TetMesh& mesh, nb::object vertex2original, const std::vector<Entries>& data) {
  std::vector<Index> original;
  assign("vertex2original", vertex2original, original);
  std::vector<DataArray> arrays;
  for (const Entries& entries : data) arrays.push_back(data_array(entries));
  {
    const nb::gil_scoped_release release;
    arrays = carry_point_data(arrays, original, mesh.points, mesh.tets);
  }
  nb::list result;
  for (DataArray& array : arrays) result.append(numpy_array(std::move(array)));
  return result;
}

template <class T>
std::map<std::string, T> by_measure(const std::array<T, kMeasures>& values) {
  std::map<std::string, T> named;
  for (std::size_t k = 0; k < kMeasures; ++k) named.emplace(to_string(static_cast<Measure>(k)), values[k]);
  return named;
}

void bind_errors(nb::module_& m) {
  const nb::exception<Error> error(m, "Error");
  error.doc() = "Base of everything tetune raises on purpose. The message says what is wrong, where, and what to do.";
  nb::exception<FileError>(m, "FileError", error).doc() = "A file that cannot be read or written.";
  const nb::exception<MeshError> mesh_error(m, "MeshError", error);
  mesh_error.doc() = "A mesh that breaks the contract of validate().";
  nb::exception<UntangleError>(m, "UntangleError", mesh_error).doc() =
      "The option untangle could not make every volume positive.";
  nb::exception<OverlapError>(m, "OverlapError", mesh_error).doc() =
      "The mesh overlaps itself, and flips there would make faces that three or more tetrahedra share.";
  nb::exception<OptionError>(m, "OptionError", error).doc() =
      "An option out of its range, or one that cannot take effect.";
  nb::exception<DeviceError>(m, "DeviceError", error).doc() = "A device that is absent, unusable or out of memory.";
}

void bind_mesh(nb::module_& m) {
  nb::class_<TetMesh>(m, "TetMesh",
                      "A tetrahedral mesh. Its arrays are views of the mesh's own memory, shared and writable; ids are "
                      "zero-based.\n\nA tag of 0 means \"no tag\". Tetrahedra that are listed inside out are "
                      "turned.")
      .def("__init__", &construct, "points"_a, "tets"_a, nb::kw_only(), "point_tags"_a = nb::none(),
           "tet_tags"_a = nb::none(), "triangles"_a = nb::none(), "triangle_tags"_a = nb::none(),
           "edges"_a = nb::none(), "edge_tags"_a = nb::none(), "corners"_a = nb::none(),
           "required_vertices"_a = nb::none(), "ridges"_a = nb::none(), "required_edges"_a = nb::none(),
           "required_triangles"_a = nb::none(), "required_tets"_a = nb::none(), "others"_a = std::vector<Block>{},
           nb::sig("def __init__(self, points: ArrayLike, tets: ArrayLike, *, point_tags: ArrayLike | None = None, "
                   "tet_tags: ArrayLike | None = None, triangles: ArrayLike | None = None, "
                   "triangle_tags: ArrayLike | None = None, edges: ArrayLike | None = None, "
                   "edge_tags: ArrayLike | None = None, corners: ArrayLike | None = None, "
                   "required_vertices: ArrayLike | None = None, ridges: ArrayLike | None = None, "
                   "required_edges: ArrayLike | None = None, required_triangles: ArrayLike | None = None, "
                   "required_tets: ArrayLike | None = None, others: Sequence[tuple[str, ArrayLike]] = ...) -> None"),
           "Copies the arrays. Each of `others` is a kind of element and the vertices of all of that kind: they stay "
           "as they are.")
      .def_prop_ro(
          "points", [](Self s) { return view(of(s).points, s); }, "Positions, (n, 3).")
      .def_prop_ro("point_tags", [](Self s) { return view(of(s).point_tags, s); })
      .def_prop_ro(
          "tets", [](Self s) { return view(of(s).tets, s); },
          "Tetrahedra (v0, v1, v2, v3) with det(v1-v0, v2-v0, v3-v0) > 0, (m, 4).")
      .def_prop_ro(
          "tet_tags", [](Self s) { return view(of(s).tet_tags, s); }, "Region (material) of each tetrahedron.")
      .def_prop_ro(
          "triangles", [](Self s) { return view(of(s).triangles, s); },
          "Listed triangles: boundary patches, interfaces and other constraints, (k, 3).")
      .def_prop_ro("triangle_tags", [](Self s) { return view(of(s).triangle_tags, s); })
      .def_prop_ro(
          "edges", [](Self s) { return view(of(s).edges, s); },
          "Listed edges: feature lines and other constraints, (k, 2).")
      .def_prop_ro("edge_tags", [](Self s) { return view(of(s).edge_tags, s); })
      .def_prop_ro(
          "corners", [](Self s) { return view(of(s).corners, s); }, "Vertices that are corners of the shape.")
      .def_prop_ro(
          "required_vertices", [](Self s) { return view(of(s).required_vertices, s); }, "Vertices that must not move.")
      .def_prop_ro(
          "ridges", [](Self s) { return view(of(s).ridges, s); }, "Rows of `edges`: sharp feature lines.")
      .def_prop_ro(
          "required_edges", [](Self s) { return view(of(s).required_edges, s); },
          "Rows of `edges` that must stay as they are.")
      .def_prop_ro(
          "required_triangles", [](Self s) { return view(of(s).required_triangles, s); },
          "Rows of `triangles` that must stay as they are.")
      .def_prop_ro(
          "required_tets", [](Self s) { return view(of(s).required_tets, s); },
          "Rows of `tets` that must stay as they are.")
      .def_prop_ro(
          "others",
          [](Self s) {
            nb::list list;
            for (ElementBlock& b : of(s).others) {
              const auto width = static_cast<std::size_t>(b.vertices_per_element);
              list.append(
                  nb::make_tuple(b.kind, nb::ndarray<nb::numpy, Index, nb::ndim<2>>(
                                             b.element2vertex.data(), {b.element2vertex.size() / width, width}, s)));
            }
            return list;
          },
          nb::sig("def others(self) -> list[tuple[str, NDArray[numpy.int32]]]"),
          "Elements of other kinds, each with its vertices.")
      .def(
          "copy", [](const TetMesh& mesh) { return mesh; }, "A mesh of its own memory.")
      .def("__repr__", [](const TetMesh& mesh) {
        return "<tetune.TetMesh: " + std::to_string(mesh.points.size()) + " vertices, " +
               std::to_string(mesh.tets.size()) + " tetrahedra, " + std::to_string(mesh.triangles.size()) +
               " listed triangles>";
      });
}

void bind_quality(nb::module_& m) {
  nb::class_<MeasureSummary>(m, "MeasureSummary", "One measure over a mesh.")
      .def_ro("min", &MeasureSummary::min)
      .def_ro("p1", &MeasureSummary::p1, "1 % of the tetrahedra are as bad as this or worse.")
      .def_ro("p5", &MeasureSummary::p5, "5 % of the tetrahedra are as bad as this or worse.")
      .def_ro("mean", &MeasureSummary::mean)
      .def_ro("max", &MeasureSummary::max);
  nb::class_<WorstTet>(m, "WorstTet", "One of the worst tetrahedra.")
      .def_ro("tet", &WorstTet::tet)
      .def_ro("dihedral", &WorstTet::dihedral, "Its smallest dihedral angle, degrees.")
      .def_ro("harmonic", &WorstTet::harmonic, "Its q_h.")
      .def_ro("centroid", &WorstTet::centroid);
  nb::class_<Quality>(m, "Quality", "Element quality of a whole mesh. Angles in degrees.")
      .def_ro("tets", &Quality::tets, "Number of tetrahedra.")
      .def_ro("dihedral_min", &Quality::dihedral_min, "Smallest dihedral angle.")
      .def_ro("dihedral_1", &Quality::dihedral_1, "1 % of all dihedral angles are smaller.")
      .def_ro("dihedral_5", &Quality::dihedral_5, "5 % of all dihedral angles are smaller.")
      .def_ro("dihedral_mean", &Quality::dihedral_mean)
      .def_ro("dihedral_max", &Quality::dihedral_max)
      .def_ro("eta_max", &Quality::eta_max)
      .def_ro("eta_95", &Quality::eta_95)
      .def_ro("eta_sum", &Quality::eta_sum, "Sum of the harmonic index, a length.")
      .def_ro("shape_sum", &Quality::shape_sum,
              "Sum of the shape energy: the number of tetrahedra if all were regular.")
      .def_ro("mean_ratio", &Quality::mean_ratio, "Mean of the mean ratio: 1 if all were regular.")
      .def_ro("mean_ratio_min", &Quality::mean_ratio_min)
      .def_ro("volume", &Quality::volume)
      .def_ro("histogram", &Quality::histogram, "Share of dihedral angles in each of 18 bins of 10 degrees.")
      .def_prop_ro(
          "measures", [](const Quality& q) { return by_measure(q.measures); }, "Each measure by its name.")
      .def_ro("worst", &Quality::worst, "The tetrahedra of smallest dihedral angle, the worst first.")
      .def("__repr__", [](const Quality& q) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "<tetune.Quality: %lld tetrahedra, dihedral angles %.2f to %.2f degrees, mean ratio %.4f>",
                      static_cast<long long>(q.tets), q.dihedral_min, q.dihedral_max, q.mean_ratio);
        return std::string(text);
      });
  nb::class_<PatchChange>(m, "PatchChange", "What became of the listed triangles of one tag.")
      .def_ro("tag", &PatchChange::tag)
      .def_ro("area_before", &PatchChange::area_before)
      .def_ro("area_change", &PatchChange::area_change, "Relative.");
  nb::class_<Comparison>(
      m, "Comparison",
      "How far one mesh lies from another of the same shape. Changes are relative, distances in mean "
      "edge lengths of the old boundary.")
      .def_ro("volume_change", &Comparison::volume_change)
      .def_ro("area_change", &Comparison::area_change)
      .def_ro("vertices_to_old", &Comparison::vertices_to_old)
      .def_ro("new_to_old", &Comparison::new_to_old)
      .def_ro("mean_edge", &Comparison::mean_edge)
      .def_ro("old_to_new", &Comparison::old_to_new)
      .def_ro("vertex_tags_kept", &Comparison::vertex_tags_kept)
      .def_ro("tet_tags_kept", &Comparison::tet_tags_kept)
      .def_ro("triangle_tags_kept", &Comparison::triangle_tags_kept)
      .def_ro("edge_tags_kept", &Comparison::edge_tags_kept)
      .def_ro("region_volume_change", &Comparison::region_volume_change)
      .def_ro("patch_area_change", &Comparison::patch_area_change)
      .def_ro("patches", &Comparison::patches)
      .def_ro("required_moved", &Comparison::required_moved)
      .def_ro("corners_moved", &Comparison::corners_moved);
}

void bind_report(nb::module_& m) {
  nb::class_<Progress>(m, "Progress", "What the progress callback sees.")
      .def_prop_ro(
          "phase", [](const Progress& p) { return std::string(p.phase); },
          "'untangling', 'flips', 'sweep', 'worst' or 'angles': what was just done.")
      .def_ro("iteration", &Progress::iteration, "Relocation sweeps done.")
      .def_ro("energy", &Progress::energy, "So far.")
      .def_ro("energy_before", &Progress::energy_before, "At the start.")
      .def_ro("worst_angle", &Progress::worst_angle,
              "Smallest dihedral angle, degrees; may be that of some passes ago.")
      .def_ro("fraction", &Progress::fraction, "Of the whole run, 0 to 1: an estimate.")
      .def_ro("seconds", &Progress::seconds, "Since the start.")
      .def_ro("seconds_left", &Progress::seconds_left, "An estimate; below 0 while there is none.");
  nb::class_<SweepReport>(m, "SweepReport", "One relocation sweep over all vertices.")
      .def_ro("iteration", &SweepReport::iteration)
      .def_ro("moved", &SweepReport::moved, "Vertices that moved.")
      .def_ro("energy_before", &SweepReport::energy_before)
      .def_ro("decrease", &SweepReport::decrease)
      .def_ro("gradient_norm", &SweepReport::gradient_norm, "Squared 2-norm of the gradient.")
      .def_ro("dihedral_min", &SweepReport::dihedral_min,
              "Smallest dihedral angle afterwards, degrees; 0 without trace_angles.")
      .def_ro("seconds", &SweepReport::seconds);
  nb::class_<FlipReport>(m, "FlipReport", "One flip pass: propose, agree, apply.")
      .def_ro("iteration", &FlipReport::iteration, "Relocation sweeps done before.")
      .def_ro("pass_", &FlipReport::pass)
      .def_ro("active", &FlipReport::active, "Tetrahedra examined.")
      .def_ro("evaluated", &FlipReport::evaluated, "Candidate flips evaluated.")
      .def_ro("flips23", &FlipReport::flips23)
      .def_ro("flips32", &FlipReport::flips32)
      .def_ro("edge_removals", &FlipReport::edge_removals)
      .def_ro("face_removals", &FlipReport::face_removals)
      .def_ro("boundary_flips", &FlipReport::boundary_flips)
      .def_ro("decrease", &FlipReport::decrease)
      .def_ro("seconds", &FlipReport::seconds)
      .def_prop_ro("flips", &FlipReport::flips);
  nb::class_<WorstReport>(m, "WorstReport", "One round of work on the worst elements.")
      .def_ro("round", &WorstReport::round)
      .def_ro("worst", &WorstReport::worst, "Tetrahedra worked on.")
      .def_ro("inserted", &WorstReport::inserted, "Vertices inserted.")
      .def_ro("removed", &WorstReport::removed, "Vertices removed.")
      .def_ro("flips", &WorstReport::flips)
      .def_ro("moved", &WorstReport::moved, "Vertices moved.")
      .def_ro("dihedral_min", &WorstReport::dihedral_min, "As of SweepReport.")
      .def_ro("seconds", &WorstReport::seconds);
  nb::class_<MissedTet>(m, "MissedTet", "An element that misses a target.")
      .def_ro("tet", &MissedTet::tet)
      .def_ro("value", &MissedTet::value)
      .def_ro("centroid", &MissedTet::centroid)
      .def_prop_ro(
          "pin", [](const MissedTet& t) { return std::string(to_string(t.pin)); }, "What holds it, in words.")
      .def_ro("edge", &MissedTet::edge)
      .def_ro("surface_angle", &MissedTet::surface_angle);
  nb::class_<TargetReport>(m, "TargetReport", "How a target was met.")
      .def_prop_ro("measure", [](const TargetReport& t) { return std::string(to_string(t.target.measure)); })
      .def_prop_ro("value", [](const TargetReport& t) { return t.target.value; })
      .def_ro("tets", &TargetReport::tets, "Elements in all.")
      .def_ro("missed", &TargetReport::missed, "Elements that miss it.")
      .def_prop_ro(
          "pinned",
          [](const TargetReport& t) {
            std::map<std::string, std::int64_t> named;
            for (std::size_t k = 0; k < kPins; ++k) {
              if (t.pinned[k] > 0) named.emplace(to_string(static_cast<Pin>(k)), t.pinned[k]);
            }
            return named;
          },
          "What holds them, and how many.")
      .def_ro("worst", &TargetReport::worst, "The worst of them.")
      .def_prop_ro("met", &TargetReport::met);
  nb::class_<Report>(m, "Report", "What optimize() did.")
      .def_ro("device", &Report::device)
      .def_ro("device_reason", &Report::device_reason, "Why that one, where the choice was automatic.")
      .def_ro("threads", &Report::threads)
      .def_ro("vertices", &Report::vertices, "Of the input.")
      .def_ro("tets_before", &Report::tets_before)
      .def_ro("tets_after", &Report::tets_after)
      .def_ro("tets_untangled", &Report::tets_untangled, "With untangle: of the input, inverted or flat.")
      .def_ro("free_vertices", &Report::free_vertices)
      .def_ro("plane_vertices", &Report::plane_vertices)
      .def_ro("line_vertices", &Report::line_vertices)
      .def_ro("fixed_vertices", &Report::fixed_vertices)
      .def_ro("surface_vertices", &Report::surface_vertices, "Where the boundary slides.")
      .def_ro("curve_vertices", &Report::curve_vertices, "Where the boundary slides.")
      .def_ro("corners_not_held", &Report::corners_not_held)
      .def_ro("edges_not_held", &Report::edges_not_held)
      .def_ro("triangles_dropped", &Report::triangles_dropped)
      .def_ro("edges_dropped", &Report::edges_dropped)
      .def_ro("colors", &Report::colors)
      .def_ro("energy_before", &Report::energy_before)
      .def_ro("energy_after", &Report::energy_after)
      .def_ro("flips23", &Report::flips23)
      .def_ro("flips32", &Report::flips32)
      .def_ro("edge_removals", &Report::edge_removals)
      .def_ro("face_removals", &Report::face_removals)
      .def_ro("boundary_flips", &Report::boundary_flips)
      .def_ro("compound_flips", &Report::compound_flips, "Edges removed together with a move of a vertex around them.")
      .def_ro("vertices_inserted", &Report::vertices_inserted)
      .def_ro("vertices_removed", &Report::vertices_removed)
      .def_ro("sweeps", &Report::sweeps)
      .def_ro("flip_passes", &Report::flip_passes)
      .def_ro("worst_rounds", &Report::worst_rounds)
      .def_prop_ro(
          "phases",
          [](const Report& r) {
            nb::dict phases;
            for (const PhaseTime& p : r.phases) phases[p.phase.c_str()] = p.seconds;
            return phases;
          },
          nb::sig("def phases(self) -> dict[str, float]"), "Seconds of each phase.")
      .def_ro("targets", &Report::targets, "One for each target, in order.")
      .def_ro("seconds", &Report::seconds)
      .def_prop_ro(
          "stop", [](const Report& r) { return std::string(to_string(r.stop)); },
          "Why it stopped, in words: 'converged', 'iteration limit', 'cancelled', ...")
      .def_prop_ro(
          "vertex2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).vertex2original, s); },
          "For each vertex of the result the one of the input, -1 for inserted ones; empty where all were kept.")
      .def_prop_ro(
          "tet2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).tet2original, s); },
          "For each tetrahedron of the result its ancestor in the input.")
      .def_prop_ro(
          "triangle2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).triangle2original, s); },
          "For each listed triangle of the result its row in the input; empty where all were kept.")
      .def_prop_ro(
          "edge2original", [](nb::handle_t<Report> s) { return view(nb::cast<Report&>(s).edge2original, s); },
          "For each listed edge of the result its row in the input; empty where all were kept.")
      .def("__repr__", [](const Report& r) {
        return "<tetune.Report: " + std::to_string(r.tets_before) + " -> " + std::to_string(r.tets_after) +
               " tetrahedra, " + to_string(r.stop) + ">";
      });
}

}  // namespace

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // VTK lets go of arrays, and with them of meshes, after the interpreter has ended
  bind_errors(m);
  bind_mesh(m);
  bind_quality(m);
  bind_report(m);
  m.def("improve", &improve, "mesh"_a, "options"_a, "progress"_a = nb::none(),
        nb::sig("def improve(mesh: TetMesh, options: dict[str, Any], progress: Callable[[Progress], object] | None = "
                "None) -> Report"),
        "Improves a mesh in place: views of its arrays are void then.");
  m.def(
      "measure_all", [](const TetMesh& mesh, int threads, int worst) { return measure_all(mesh, threads, worst); },
      "mesh"_a, nb::kw_only(), "threads"_a = 0, "worst"_a = 10, nb::call_guard<nb::gil_scoped_release>());
  m.def("carry_point_data", &carry, "mesh"_a, "vertex2original"_a, "data"_a,
        nb::sig("def carry_point_data(mesh: TetMesh, vertex2original: NDArray[numpy.int32], "
                "data: Sequence[NDArray[Any]]) -> list[NDArray[Any]]"),
        "Data of the vertices of a mesh after some were inserted: means for float64 and float32, the nearest vertex's "
        "for int32. Each array has two dimensions.");
  m.def("measure_each", &measures_by_name, "mesh"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def measure_each(mesh: TetMesh, *, threads: int = 0) -> dict[str, NDArray[numpy.float64]]"));
  m.def(
      "compare",
      [](const TetMesh& before, const TetMesh& after, int threads) { return compare(before, after, threads); },
      "before"_a, "after"_a, nb::kw_only(), "threads"_a = 0, nb::call_guard<nb::gil_scoped_release>(),
      "Compares two meshes of one shape: volume, surface, tags.");
  m.def(
      "validate",
      [](const TetMesh& mesh, int threads) {
        const nb::gil_scoped_release release;
        const ValidationReport report = validate(mesh, threads);
        return report.ok() ? std::string() : report.message(false);
      },
      "mesh"_a, nb::kw_only(), "threads"_a = 0,
      "What is wrong with a mesh, in words: one line for each kind of defect with its first places. Empty for a mesh "
      "that optimize() accepts.");
  m.def(
      "read_mesh",
      [](const std::string& path, int threads) {
        std::vector<std::string> warnings;
        TetMesh mesh = [&] {
          const nb::gil_scoped_release release;
          return read_mesh(path, &warnings, threads);
        }();
        for (const std::string& w : warnings) warn(w);
        return mesh;
      },
      "path"_a, nb::kw_only(), "threads"_a = 0);
  m.def(
      "write_mesh",
      [](const std::string& path, const TetMesh& mesh, int threads) {
        std::vector<std::string> warnings;
        {
          const nb::gil_scoped_release release;
          write_mesh(path, mesh, threads, &warnings);
        }
        for (const std::string& w : warnings) warn(w);
      },
      "path"_a, "mesh"_a, nb::kw_only(), "threads"_a = 0);
}

}  // namespace tetune::python
