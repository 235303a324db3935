// SPDX-License-Identifier: Apache-2.0
#include "io/registry.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "backend/span.hpp"
#include "io/unv/unv_format.hpp"
#include "mesh/validate_arrays.hpp"
#include "system/native.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"
#include "tetune/quality.hpp"
#include "tetune/series.hpp"

namespace tetune {
namespace {

/// Whether the vertices have numbers other than their positions. An inserted one, which is the last, has 0.
bool has_own_numbers(const TetMesh& mesh) {
  for (std::size_t v = 0; v < mesh.deck_nodes.size(); ++v) {
    if (mesh.deck_nodes[v] != std::int64_t(v) + 1 && mesh.deck_nodes[v] != 0) return true;
  }
  return false;
}

/// Warns of what the format of a file does not hold, beside elements, tags and data.
void warn_of_lost_contents(const std::string& path, const TetMesh& mesh, const Format::Holds& holds,
                           const IoContext& context) {
  if (!mesh.periodic.empty() && !holds.periodic_links) context.warn(path + ": the format cannot hold periodic links");
  if (mesh.deck != nullptr && !holds.deck) context.warn(path + ": " + lost_deck(mesh));
  if (mesh.deck == nullptr && !holds.node_numbers && has_own_numbers(mesh)) {
    context.warn(path + ": the format cannot hold the numbers of nodes: they are numbered in their order");
  }
  const std::string unit = unv_length_unit(mesh);
  if (unit.empty() || holds.length_unit) return;
  context.warn(path + ": the format cannot hold the unit of length: coordinates are in that of the input, the " + unit);
}

enum class Access { read, write };

bool allows(const Format& format, Access access) { return access == Access::read ? format.reads() : format.writes(); }

std::string endings(Access access) {
  std::string known;
  for (const Format& format : formats()) {
    if (!allows(format, access)) continue;
    for (const std::string& e : format.endings) known += (known.empty() ? "" : " ") + e;
  }
  return known;
}

/// Writes a format of one file.
template <void (*Write)(FileWriter& file, const TetMesh& mesh, const IoContext& context)>
void write_file(const std::string& path, const TetMesh& mesh, const IoContext& context) {
  FileWriter file(path);
  Write(file, mesh, context);
  file.commit();
}

/// The ending, with the one before it for compressed files.
std::string whole_ending_of(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == ".gz" ? ending_of(path_of(path).stem().string()) + ending : ending;
}

/// Advice on files of formats that are not read, or nothing.
std::string advice_on(const std::string& ending) {
  if (ending == ".cdb") return "; the Python package mapdl-archive converts archives of ANSYS to .vtu";
  if (ending == ".fem") return "; a deck of OptiStruct is one of Nastran: name it .bdf";
  if (ending == ".dat") return "; if it is a deck of Nastran, name it .bdf, if one of Abaqus or CalculiX, .inp";
  return {};
}

const Format& format_of(const std::string& path, Access access) {
  const std::string ending = whole_ending_of(path);
  bool other_way = false;
  for (const Format& format : formats()) {
    if (!format.has_ending(ending)) continue;
    if (allows(format, access)) return format;
    other_way = true;
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(path_of(path), ignored)) throw FileError(path + ": is a folder; give a file name");
  const bool is_write = access == Access::write;
  if (!is_write && !std::filesystem::exists(path_of(path), ignored)) throw FileError(path + ": there is no such file");
  const std::string advice = is_write || other_way ? std::string() : advice_on(ending);
  throw FileError(path + ": tetune " +
                  (!other_way ? "does not "
                   : is_write ? "reads, but does not "
                              : "writes, but does not ") +
                  (is_write ? "write" : "read") + " files of ending \"" + ending + "\"" + advice +
                  "; known endings: " + endings(access));
}

/// Throws FileError where arrays of tags or data differ in length from those of their elements, by which writers index
/// them, where a list or an element names an entity that does not exist, or where there are two blocks of one kind and
/// order.
void check_arrays(const std::string& path, const TetMesh& mesh) {
  if (const ValidationReport report = validate_indices(mesh); !report.ok()) {
    throw FileError(path + ": " + report.message(false));
  }
  for (const ElementBlock& block : mesh.others) {
    const auto same_kind = [&block](const ElementBlock& b) {
      return b.kind == block.kind && b.second_order == block.second_order;
    };
    if (std::count_if(mesh.others.begin(), mesh.others.end(), same_kind) > 1) {
      throw FileError(path + ": the mesh has two blocks of " + block.kind + "; a file can hold one of each order");
    }
  }
}

/// Reverses tetrahedra that are listed inside out, with a warning where not all were.
void orient(const std::string& path, TetMesh& mesh, const IoContext& context) {
  const std::int64_t reversed = orient_uniformly(mesh, context.threads);
  if (reversed > 0 && reversed < std::ssize(mesh.tets)) {
    context.warn(path + ": " + std::to_string(reversed) + " of " + std::to_string(mesh.tets.size()) +
                 " tetrahedra are listed inside out, unlike their neighbors; they were reversed");
  }
}

/// Returns the mesh with its measures as data on tetrahedra.
TetMesh with_measures(TetMesh mesh, const std::vector<Measures>& measures) {
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const std::string name = to_string(Measure(k));
    std::erase_if(mesh.tet_data, [&name](const DataArray& array) { return array.name == name; });
    std::vector<double> values(measures.size());
    for (std::size_t t = 0; t < values.size(); ++t) values[t] = measures[t][k];
    mesh.tet_data.push_back({name, 1, std::move(values)});
  }
  return mesh;
}

/// Nodes of vertices alone, as the format has no element with mid-side nodes.
constexpr Format::Holds kVertices = {.mid_side_nodes = false};
constexpr Format::Holds kPeriodicLinks = {.periodic_links = true};

}  // namespace

const std::vector<Format>& formats() {
  static const std::vector<Format> list = {
      {.name = "MEDIT text",
       .endings = {".mesh"},
       .read = read_medit,
       .write = write_file<write_medit_text>,
       .holds = kVertices},
      {.name = "MEDIT binary",
       .endings = {".meshb"},
       .read = read_medit,
       .write = write_file<write_medit_binary>,
       .holds = kVertices},
      {.name = "TetGen",
       .endings = {".ele", ".node", ".face"},
       .read = read_tetgen,
       .write = write_tetgen,
       .is_set = true,
       .holds = kVertices},
      {.name = "VTK XML", .endings = {".vtu"}, .plugin = &kVtkPlugin},
      {.name = "VTK XML in parts",
       .endings = {".pvtu"},
       .plugin = &kVtkPlugin,
       .plugin_writes = false,
       .parts = vtk_pieces},
      {.name = "VTK legacy", .endings = {".vtk"}, .plugin = &kVtkPlugin},
      {.name = "Exodus", .endings = {".e", ".ex2", ".exo"}, .plugin = &kVtkPlugin, .has_times = true},
      {.name = "Gmsh", .endings = {".msh"}, .read = read_msh, .write = write_file<write_msh>, .holds = kPeriodicLinks},
      {.name = "Abaqus, CalculiX",
       .endings = {".inp"},
       .read = read_inp,
       .write = write_file<write_inp>,
       .holds = {.deck = true},
       .parts = included_inp_files},
      {.name = "SU2", .endings = {".su2"}, .read = read_su2, .write = write_file<write_su2>, .holds = kVertices},
      {.name = "Netgen",
       .endings = {".vol"},
       .read = read_netgen,
       .write = write_file<write_netgen>,
       .holds = kPeriodicLinks},
      {.name = "Netgen, compressed",
       .endings = {".vol.gz"},
       .read = read_netgen,
       .write = write_file<write_netgen_compressed>,
       .holds = kPeriodicLinks},
      {.name = "Nastran",
       .endings = {".bdf", ".nas"},
       .read = read_nastran,
       .write = write_file<write_nastran>,
       .holds = {.node_numbers = true},
       .parts = included_nastran_files},
      {.name = "I-deas universal",
       .endings = {".unv"},
       .read = read_unv,
       .write = write_file<write_unv>,
       .holds = {.node_numbers = true, .length_unit = true}},
      {.name = "MED", .endings = {".med"}, .plugin = &kGmshPlugin, .is_optional = true},
      {.name = "CGNS", .endings = {".cgns"}, .plugin = &kGmshPlugin, .is_optional = true},
  };
  return list;
}

std::string excess_of(std::int64_t entries, Index max) {
  if (entries <= max) return "";
  return std::to_string(entries) + " entries; tetune takes at most " + std::to_string(max);
}

std::vector<std::string> files_of(const std::string& path) {
  for (const Format& format : formats()) {
    if (!format.is_set || !format.has_ending(ending_of(path))) continue;
    std::vector<std::string> files;
    for (const std::string& ending : format.endings) files.push_back(with_ending(path, ending));
    return files;
  }
  return {path};
}

std::vector<std::string> files_read(const std::string& path) {
  std::vector<std::string> files = files_of(path);
  const std::string ending = ending_of(path);
  try {
    for (const Format& format : formats()) {
      if (format.parts == nullptr || !format.has_ending(ending)) continue;
      for (std::string& part : format.parts(path)) files.push_back(std::move(part));
    }
    if (ending != ".pvd") return files;
    for (const SeriesStep& step : read_series(path)) {
      if (ending_of(step.path) == ".pvd") continue;  // no mesh
      for (std::string& file : files_read(step.path)) files.push_back(std::move(file));
    }
  } catch (const FileError&) {
    // That file is not read either.
  }
  return files;
}

std::string readable_endings() { return endings(Access::read); }
std::string writable_endings() { return endings(Access::write); }

std::vector<double> read_times(const std::string& path) {
  return read_times_by_plugin(*format_of(path, Access::read).plugin, path);
}

TetMesh read_mesh_at(const std::string& path, int time, const IoContext& context) {
  const Format& format = format_of(path, Access::read);
  TetMesh mesh =
      format.read != nullptr ? format.read(path, context) : read_by_plugin(*format.plugin, path, context, time);
  orient(path, mesh, context);
  return mesh;
}

TetMesh read_mesh(const std::string& path, std::vector<std::string>* warnings, int threads) {
  return read_mesh_at(path, 0, {threads, warnings});
}

TetMesh parse_mesh(const std::string& name, std::string_view bytes, std::vector<std::string>* warnings, int threads) {
  const IoContext context{threads, warnings};
  TetMesh mesh = parse_medit(name, bytes, context);
  orient(name, mesh, context);
  return mesh;
}

void check_place(const std::string& path) {
  const std::filesystem::path place = native::long_path(path);
  const std::filesystem::path folder = place.parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  std::error_code ignored;
  if (!std::filesystem::is_directory(path_of(name), ignored))
    throw FileError(path + ": the folder " + name + " does not exist");
  if (std::filesystem::is_directory(place, ignored)) throw FileError(path + ": is a folder; give a file name");
  if (std::filesystem::exists(place, ignored) && !std::filesystem::is_regular_file(place, ignored)) {
    throw FileError(path + ": exists and is not a regular file; give another name, or - for the standard output");
  }
  if (!native::is_writable(name)) throw FileError(path + ": no permission to write in " + name);
  const FileWriter trial(path);  // some file systems refuse what permissions allow
}

void check_writable(const std::string& path) {
  const Format& format = format_of(path, Access::write);
  if (format.write == nullptr) require_plugin(*format.plugin, path);
  check_place(path);
  if (format.is_optional || (format.write == nullptr && is_script(*format.plugin)))
    require_format(*format.plugin, path);
}

void check_second_order(const std::string& path) {
  if (format_of(path, Access::write).holds.mid_side_nodes) return;
  std::string others;
  for (const Format& format : formats()) {
    if (format.writes() && format.holds.mid_side_nodes) others += " " + format.endings.front();
  }
  throw FileError(path + ": the format has no nodes in the middles of edges; write one of" + others);
}

void write_mesh(const std::string& path, const TetMesh& mesh, int threads, std::vector<std::string>* warnings) {
  const Format& format = format_of(path, Access::write);
  check_writable(path);
  check_arrays(path, mesh);
  const IoContext context{threads, warnings};
  warn_of_lost_contents(path, mesh, format.holds, context);
  if (format.write != nullptr) {
    std::vector<std::string> losses;
    try {
      format.write(path, mesh, {threads, &losses});
    } catch (const FileError& e) {
      const std::vector<std::string> files = files_of(path);
      const auto is_named = [&e](const std::string& file) { return std::string_view(e.what()).starts_with(file); };
      if (std::any_of(files.begin(), files.end(), is_named)) throw;
      throw FileError(path + ": " + e.what());
    }
    for (const std::string& loss : losses) context.warn(path + ": " + loss);
  } else {
    TemporaryFile file(path);
    write_by_plugin(*format.plugin, path, file.name(), mesh, context);
    file.replace();
  }
}

void write_mesh(int descriptor, const std::string& name, bool binary, const TetMesh& mesh, int threads,
                std::vector<std::string>* warnings) {
  check_arrays(name, mesh);
  const IoContext context{threads, warnings};
  warn_of_lost_contents(name, mesh, {}, context);
  std::vector<std::string> losses;
  FileWriter file(descriptor, name);
  (binary ? write_medit_binary : write_medit_text)(file, mesh, {threads, &losses});
  file.commit();
  for (const std::string& loss : losses) context.warn(name + ": " + loss);
}

void write_text(const std::string& path, std::string_view text) {
  check_place(path);
  FileWriter file(path);
  file.write(text);
  file.commit();
}

void write_measures(const std::string& path, const TetMesh& mesh, int threads, std::vector<std::string>* warnings) {
  constexpr const char* kWithData[] = {".vtu", ".vtk", ".e", ".ex2", ".exo", ".msh"};
  const std::string ending = ending_of(path);
  const bool with_mesh = std::find(std::begin(kWithData), std::end(kWithData), ending) != std::end(kWithData);
  if (!with_mesh && ending != ".sol") {
    throw FileError(path +
                    ": measures are written as a MEDIT solution (.sol), or with the mesh as .vtu, .vtk, .e or .msh");
  }
  if (with_mesh) {
    check_writable(path);
    return write_mesh(path, with_measures(mesh, measure_each(mesh, threads)), threads, warnings);
  }
  check_place(path);
  const std::vector<Measures> measures = measure_each(mesh, threads);
  FileWriter file(path);
  write_medit_solution(file, measures, threads);
  file.commit();
}

}  // namespace tetune
