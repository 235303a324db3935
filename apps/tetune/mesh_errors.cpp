// SPDX-License-Identifier: Apache-2.0
#include "mesh_errors.hpp"

#include <fmt/format.h>

#include "geometry_files.hpp"
#include "option_flags.hpp"

namespace tetune::cli {
namespace {

/// An error of optimize() and the like.
std::string mesh_message(const MeshError& error, const TetMesh& mesh, int threads, const char* advice) {
  if (const auto* overlap = dynamic_cast<const OverlapError*>(&error)) return with_flags(overlap->message(true));
  if (const auto* curved = dynamic_cast<const CurvedError*>(&error)) {
    return with_flags(curved->message(true)) + " `tetune info` measures them.";
  }
  const ValidationReport valid = validate(mesh, threads);
  return valid.ok() ? with_library_flags(error.what()) : validity_message(valid, mesh, advice);
}

}  // namespace

std::string untangle_message(const UntangleError& error, const TetMesh& mesh) {
  const std::string text = with_flags(error.message(true));
  // It has the position of second-order elements.
  if (error.reason == UntangleError::Reason::curved_surface) return text + "\n  No mesh was written.";
  Point3 center{};
  for (const Index v : mesh.tets.at(static_cast<std::size_t>(error.left.at(0)))) {
    const Point3& p = mesh.points[static_cast<std::size_t>(v)];
    for (std::size_t k = 0; k < 3; ++k) center[k] += 0.25 * p[k];
  }
  return fmt::format("{}\n  The first is near {:.6g} {:.6g} {:.6g}. No mesh was written.", text, center[0], center[1],
                     center[2]);
}

std::string validity_message(const ValidationReport& report, const TetMesh& mesh, const char* advice) {
  return report.message(true, !mesh.curved_edges.empty()
                                  ? "the straight tetrahedra of a curved mesh have to be valid first: make it one "
                                    "of straight tetrahedra (tetune convert --order 1) and untangle this "
                                    "(--untangle)"
                                  : advice);
}

void rethrow_with_message(const std::string& file, const TetMesh& mesh, int threads, const char* advice) {
  try {
    throw;
  } catch (const UntangleError& e) {
    throw MeshError(file + ": " + untangle_message(e, mesh));
  } catch (const MeshError& e) {
    throw MeshError(file + ": " + mesh_message(e, mesh, threads, advice));
  } catch (const OptionError& e) {
    throw OptionError(file + ": " + with_library_flags(e.what()));
  } catch (const DeviceError& e) {
    throw DeviceError(file + ": " + with_flags(e.what()));
  }
}

}  // namespace tetune::cli
