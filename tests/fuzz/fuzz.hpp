// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: the readers, what plugins answer, and through them validate() and optimize(); optimize() on any arrays
// and options; the command line. `tests/fuzz/run 60` builds them with clang and runs each for 60 seconds. A finding is
// written to build/fuzz/found: give that file as the only argument to run it again, as in
//   build/fuzz/tests/fuzz/fuzz_optimize build/fuzz/found/optimize-crash-...
#pragma once

#include <stdlib.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "tetune/tetune.hpp"

namespace tetune::fuzz {

/// Where inputs are put, as readers take paths; gone when the process ends by itself.
class Folder {
 public:
  Folder() {
    // In memory where there is such a place.
    const std::filesystem::path memory = "/dev/shm";
    std::error_code error;
    const bool there = std::filesystem::is_directory(memory, error);
    std::string name = ((there ? memory : std::filesystem::temp_directory_path()) / "tetune_fuzz_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string put(const std::string& name, std::string_view bytes) const {
    const std::string file = (path_ / name).string();
    std::FILE* out = std::fopen(file.c_str(), "wb");
    if (out == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), out) != bytes.size()) std::abort();
    std::fclose(out);
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// What a reader made can be validated; a valid mesh can be optimised and stays valid. Anything else ends the process.
inline void check(TetMesh mesh) {
  if (!validate(mesh, 1).ok() || mesh.tets.size() >= 2000) return;
  const std::size_t vertices = mesh.points.size();
  const Quality before = quality(mesh, 1);
  Options options;
  options.device = Device::cpu;
  options.max_iterations = 2;
  options.threads = 1;
  const Report report = optimize(mesh, options);
  const ValidationReport after = validate(mesh, 1);
  if (!after.ok()) {
    std::fprintf(stderr, "after optimize(): %s\n", after.message(true).c_str());
    std::abort();
  }
  // Of elements so flat that rounding decides, the energy is noise.
  const bool meaningful = before.mean_ratio_min > 1e-6;
  const double energy = quality(mesh, 1).eta_sum;
  if (mesh.points.size() != vertices || (meaningful && energy > before.eta_sum * (1 + 1e-9))) {
    std::fprintf(stderr, "vertices %zu -> %zu, energy %.17g -> %.17g\n", vertices, mesh.points.size(), before.eta_sum,
                 energy);
    std::abort();
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
  check(std::move(mesh));
}

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace tetune::fuzz
