// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: the readers, what plugins answer, and through them validate() and optimize(); optimize() on any arrays
// and options; the command line. `tests/fuzz/run 60` builds them with clang and runs each for 60 seconds. A finding is
// written to build/fuzz/found: give that file as the only argument to run it again, as in
//   build/fuzz/tests/fuzz/fuzz_optimize build/fuzz/found/optimize-crash-...
#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <string_view>

#include "tetune/tetune.hpp"

namespace tetune::fuzz {

/// A folder for inputs, as readers take paths; removed when the process ends without a crash. Files stay open, and
/// equal content is not written again: that took a third of the time.
class Folder {
 public:
  Folder() {
    // In memory where the system has such a folder.
    const std::filesystem::path memory = "/dev/shm";
    std::error_code error;
    const bool has_memory = std::filesystem::is_directory(memory, error);
    std::string name = ((has_memory ? memory : std::filesystem::temp_directory_path()) / "tetune_fuzz_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string put(const std::string& name, std::string_view bytes) {
    const std::string path = this->path(name);
    const auto [at, is_new] = files_.try_emplace(name);
    File& file = at->second;
    if (is_new) file.descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (!is_new && file.bytes == bytes) return path;
    if (::pwrite(file.descriptor, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) std::abort();
    if (file.bytes.size() > bytes.size() && ::ftruncate(file.descriptor, static_cast<off_t>(bytes.size())) != 0) {
      std::abort();
    }
    file.bytes = bytes;
    return path;
  }
  void remove(const std::string& name) {
    const auto at = files_.find(name);
    if (at == files_.end()) return;
    ::close(at->second.descriptor);
    files_.erase(at);
    if (!std::filesystem::remove(path_ / name)) std::abort();
  }

 private:
  struct File {
    int descriptor = -1;
    std::string bytes;
  };
  std::filesystem::path path_;
  std::map<std::string, File> files_;
};

/// Whether rounding decides about angles: where the smallest is below a thousandth of a degree, or the longest edge is
/// too long to add the shortest to it without loss of its digits.
inline bool is_doubtful(const TetMesh& mesh, const Quality& quality) {
  constexpr double kFlat = 1e-3;
  constexpr double kLengths = 1e10;
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0;
  for (const auto& tet : mesh.tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Point3& a = mesh.points[static_cast<std::size_t>(tet[i])];
        const Point3& b = mesh.points[static_cast<std::size_t>(tet[j])];
        const double length = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
      }
    }
  }
  return quality.dihedral_min < kFlat || !(longest < kLengths * shortest);
}

[[noreturn]] inline void fail(const std::string& what) {
  std::fprintf(stderr, "optimize(): %s\n", what.c_str());
  std::abort();
}

/// Whether elements are curved and not proved valid: they are refused without untangling.
inline bool has_invalid_curved(const TetMesh& mesh) {
  const CurvedQuality curved = measure_curved(mesh, 1);
  return curved.valid != curved.tets;
}

/// Properties of any optimization except of the harmonic energy.
inline void check_worst(const TetMesh& mesh, const Quality& before, const Quality& after, Effort effort) {
  if (is_doubtful(mesh, before)) return;
  const auto check = [](const char* name, double old_value, double new_value) {
    if (new_value < old_value * (1 - 1e-9)) {
      fail(std::string(name) + " " + std::to_string(old_value) + " -> " + std::to_string(new_value));
    }
  };
  check("smallest angle", before.dihedral_min, after.dihedral_min);
  constexpr double kAllowedAngle = 165;
  check("180 degrees less the largest angle", 180 - std::max(before.dihedral_max, kAllowedAngle),
        180 - after.dihedral_max);
  const double kept_part = effort == Effort::best ? 0.25 : 1;
  check("smallest mean ratio", kept_part * before.mean_ratio_min, after.mean_ratio_min);
}

/// Checks that a mesh from a reader can be validated, and that a valid mesh can be optimized and stays valid. Anything
/// else ends the process.
inline void check(const TetMesh& mesh) {
  if (!validate(mesh, 1).ok() || mesh.tets.size() >= 2000 || has_invalid_curved(mesh)) return;
  const Quality before = quality(mesh, 1);
  for (const Effort effort : {Effort::fast, Effort::standard}) {
    Options options;
    options.device = Device::cpu;
    options.effort = effort;
    options.max_iterations = 2;
    options.threads = 1;
    TetMesh result = mesh;
    try {
      optimize(result, options);
    } catch (const OverlapError&) {
      if (result.tets != mesh.tets || result.points != mesh.points) fail("refused, and changed");
      continue;
    }
    if (const ValidationReport valid = validate(result, 1); !valid.ok()) fail(valid.message(true));
    if (result.points.size() != mesh.points.size()) fail("vertices came or went");
    const Quality after = quality(result, 1);
    check_worst(mesh, before, after, effort);
    // The work on the worst elements may give some of it back.
    if (effort == Effort::fast && after.shape_sum > before.shape_sum * (1 + 1e-9) && !is_doubtful(mesh, before)) {
      fail("energy " + std::to_string(before.shape_sum) + " -> " + std::to_string(after.shape_sum));
    }
  }
}

/// Reads a file: it is refused with FileError, or the mesh is checked.
inline void check(const std::string& file) {
  TetMesh mesh;
  try {
    mesh = read_mesh(file, nullptr, 1);
  } catch (const FileError&) {
    return;
  }
  check(mesh);
}

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// One input of a target for a format that is read.
inline int check_reader(const std::uint8_t* data, std::size_t size, const std::string& ending) {
  static Folder folder;
  check(folder.put("in" + ending, text(data, size)));
  return 0;
}

/// The coordinates that a format keeps.
enum class Coordinates { exact, rounded };

/// Fails unless a mesh is read back as it was written.
inline void check_written(const std::string& path, const std::string& out, Coordinates coordinates) {
  const TetMesh mesh = read_mesh(path, nullptr, 1);
  if (!validate(mesh, 1).ok()) return;
  write_mesh(out, mesh, 1);
  const TetMesh back = read_mesh(out, nullptr, 1);
  const bool has_points =
      coordinates == Coordinates::exact ? back.points == mesh.points : back.points.size() == mesh.points.size();
  const auto same_others = [&back](const ElementBlock& block) {
    return block.kind == kPoints ||
           std::any_of(back.others.begin(), back.others.end(), [&block](const ElementBlock& b) {
             return b.kind == block.kind && b.second_order == block.second_order &&
                    b.element2vertex == block.element2vertex;
           });
  };
  if (!has_points || back.tets.size() != mesh.tets.size() || back.triangles != mesh.triangles ||
      back.edges != mesh.edges || !std::all_of(mesh.others.begin(), mesh.others.end(), same_others)) {
    fail("a written mesh was read back as another one");
  }
}

/// Same as check_reader(), for a text format that is also written.
inline int check_format(const std::uint8_t* data, std::size_t size, const std::string& ending,
                        Coordinates coordinates) {
  static Folder folder;
  const std::string path = folder.put("in" + ending, text(data, size));
  try {
    check_written(path, folder.path("out" + ending), coordinates);
  } catch (const FileError&) {
    return 0;
  }
  check(path);
  return 0;
}

}  // namespace tetune::fuzz
