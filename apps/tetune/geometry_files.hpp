// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <future>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "optimize_arguments.hpp"
#include "tetune/optimize_on_geometry.hpp"

/// CAD geometry on the command line.
namespace tetune::cli {

/// Defines --geometry and --geometry-unit.
void define_geometry(CLI::App& command, GeometryArguments& arguments, const std::string& group,
                     const std::string& purpose);

/// Defines --geometry, --geometry-unit and --snap of `tetune optimize`.
void define_geometry_to_slide_on(CLI::App& command, GeometryArguments& arguments);

/// One warning for each given option that has no effect without --geometry.
std::vector<std::string> flags_without_geometry(const CLI::App& command, const GeometryArguments& arguments);

/// Throws OptionError for options that the geometry excludes, and warns of those that have no effect without it.
void check_geometry_arguments(const CLI::App& command, OptimizeArguments& arguments);

/// A text of the library with its options, the unit of a geometry and the order of a mesh written as flags.
std::string with_library_flags(const std::string& text);

/// The length in mm of a unit, which is a name or a number. Throws OptionError.
double unit_in_mm(const std::string& unit);

/// Reads the geometry beside the caller; invalid if none is given.
std::future<Geometry> start_reading(const GeometryArguments& arguments, int threads);

/// The surface of a mesh, its classification as tags and as data of vertices, triangles and edges.
TetMesh classified_mesh(const TetMesh& mesh, const GeometryMatch& match);

std::string match_table(const Geometry& geometry, const GeometryMatch& match);
nlohmann::ordered_json to_json(const Geometry& geometry, const GeometryMatch& match);

/// The warnings of a run on a geometry.
std::vector<std::string> geometry_warnings(const GeometryReport& report);
/// The numbers of vertices that were moved onto the geometry, and the distances from it.
std::string geometry_summary(const Geometry& geometry, const GeometryReport& report);
/// The report on a geometry without its Report.
nlohmann::ordered_json to_json(const Geometry& geometry, const GeometryReport& report);

}  // namespace tetune::cli
