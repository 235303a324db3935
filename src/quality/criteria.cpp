// SPDX-License-Identifier: Apache-2.0
#include "tetune/criteria.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mesh/messages.hpp"
#include "quality/check_measures.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

using M = CheckMeasure;

// CheckMeasureInfo::larger_is_better and ::of_faces.
constexpr bool kLarger = true, kSmaller = false;
constexpr bool kOfFaces = true, kOfTets = false;

CheckMeasureInfo info(Measure measure) {
  const bool is_angle = measure == Measure::min_dihedral || measure == Measure::max_dihedral;
  return {M(measure), to_string(measure),        larger_is_better(measure),
          kOfTets,    is_angle ? "degrees" : "", is_angle ? kRegularDihedral : 1};
}

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
/// The regular tetrahedron's sqrt(3/2).
constexpr double kRegularEdgeAltitude = 1.2247448713915890;

const std::array<CheckMeasureInfo, kCheckMeasures> kMeasureTable{
    info(Measure::min_dihedral),
    info(Measure::max_dihedral),
    info(Measure::mean_ratio),
    info(Measure::sicn),
    info(Measure::gamma),
    info(Measure::scaled_jacobian),
    info(Measure::radius_ratio),
    info(Measure::aspect_ratio),
    info(Measure::harmonic),
    CheckMeasureInfo{M::volume, "volume", kLarger, kOfTets, "length^3", kUnbounded},
    CheckMeasureInfo{M::jacobian_ratio, "jacobian_ratio", kSmaller, kOfTets, "", 1},
    CheckMeasureInfo{M::min_face_angle, "min_face_angle_deg", kLarger, kOfTets, "degrees", 60},
    CheckMeasureInfo{M::max_face_angle, "max_face_angle_deg", kSmaller, kOfTets, "degrees", 60},
    CheckMeasureInfo{M::equiangle_skew, "equiangle_skew", kSmaller, kOfTets, "", 0},
    CheckMeasureInfo{M::volume_skew, "volume_skew", kSmaller, kOfTets, "", 0},
    CheckMeasureInfo{M::collapse, "collapse", kLarger, kOfTets, "", 1},
    CheckMeasureInfo{M::edge_ratio, "edge_ratio", kSmaller, kOfTets, "", 1},
    CheckMeasureInfo{M::edge_altitude_ratio, "edge_altitude_ratio", kSmaller, kOfTets, "", kRegularEdgeAltitude},
    CheckMeasureInfo{M::triangle_aspect, "triangle_aspect", kSmaller, kOfTets, "", 1},
    CheckMeasureInfo{M::shortest_edge, "shortest_edge", kLarger, kOfTets, "length", kUnbounded},
    CheckMeasureInfo{M::min_altitude, "min_altitude", kLarger, kOfTets, "length", kUnbounded},
    CheckMeasureInfo{M::orthogonal_quality, "orthogonal_quality", kLarger, kOfTets, "", 1},
    CheckMeasureInfo{M::non_orthogonality, "non_orthogonality_deg", kSmaller, kOfFaces, "degrees", 0},
    CheckMeasureInfo{M::face_skewness, "face_skewness", kSmaller, kOfFaces, "", 0}};

/// The limit by which no volume may be zero or negative: check() measures a positive one as at least this, even
/// where it is below the range of normal doubles.
constexpr double kSmallestVolume = std::numeric_limits<double>::min();
/// The solver refuses a determinant, which is six times the volume, below 1e-20.
constexpr double kCalculixVolume = 1e-20 / 6;

AcceptanceCriterion fails(M measure, double limit, const char* source) {
  return {measure, std::nullopt, limit, 0, source};
}
AcceptanceCriterion warns(M measure, double limit, const char* source) {
  return {measure, limit, std::nullopt, 0, source};
}
AcceptanceCriterion both(M measure, double warn, double fail, const char* source) {
  return {measure, warn, fail, 0, source};
}

const std::array kPresets{
    AcceptanceCriteria{
        "abaqus",
        {fails(M::volume, kSmallestVolume, "the input file processor refuses volumes that are not positive"),
         warns(M::volume_skew, 1 - 1e-4, "Abaqus/CAE, Verify Mesh, shape metrics: shape factor 0.0001"),
         warns(M::min_face_angle, 5, "Abaqus/CAE, Verify Mesh, shape metrics: smaller face corner angle"),
         warns(M::max_face_angle, 170, "Abaqus/CAE, Verify Mesh, shape metrics: larger face corner angle"),
         warns(M::edge_ratio, 10, "Abaqus/CAE, Verify Mesh, shape metrics: aspect ratio")}},
    AcceptanceCriteria{
        "ansys",
        {fails(M::volume, kSmallestVolume, "Mechanical APDL refuses volumes that are not positive"),
         both(M::triangle_aspect, 20, 1e6, "Mechanical APDL, SHPP, aspect ratio"),
         both(M::max_face_angle, 165, 179.9, "Mechanical APDL, SHPP, maximum corner angle of triangles")}},
    AcceptanceCriteria{
        "calculix", {fails(M::volume, kCalculixVolume, "ccx, e_c3d: nonpositive jacobian determinant, below 1e-20")}},
    AcceptanceCriteria{
        "fluent",
        {fails(M::volume, kSmallestVolume, "Fluent User's Guide, Checking the Mesh: volumes must be positive"),
         fails(M::orthogonal_quality, 0.01, "Fluent User's Guide, Mesh Quality: more than 0.01"),
         warns(M::volume_skew, 0.95, "Fluent User's Guide, Mesh Quality: skewness below 0.95")}},
    AcceptanceCriteria{"nastran",
                       {fails(M::volume, kSmallestVolume, "GEOMCHECK TET_DETJ: the determinant must be positive"),
                        warns(M::edge_altitude_ratio, 100, "GEOMCHECK TET_AR"),
                        warns(M::min_face_angle, 5, "Autodesk Nastran, TETFACEMINIATOL"),
                        warns(M::max_face_angle, 170, "Autodesk Nastran, TETFACEMAXIATOL")}},
    AcceptanceCriteria{"openfoam",
                       {fails(M::volume, kSmallestVolume, "checkMesh: cell volumes must be positive"),
                        both(M::non_orthogonality, 70, 90, "checkMesh, primitiveMesh::nonOrthThreshold_"),
                        fails(M::face_skewness, 4, "checkMesh, primitiveMesh::skewThreshold_")}}};

/// Whether no element meets a limit. One that is the best value, rounded to six digits, is accepted.
bool is_out_of_reach(double limit, const CheckMeasureInfo& measure) {
  if (std::isinf(measure.best)) return false;
  const double rounding = 1e-5 * measure.best;
  return measure.larger_is_better ? limit > measure.best + rounding : limit < measure.best - rounding;
}

}  // namespace

std::span<const CheckMeasureInfo> check_measures() { return kMeasureTable; }

const CheckMeasureInfo& info_of(CheckMeasure measure) { return kMeasureTable.at(std::size_t(measure)); }

const CheckMeasureInfo* find_check_measure(std::string_view name) {
  const auto found = std::find_if(kMeasureTable.begin(), kMeasureTable.end(),
                                  [name](const CheckMeasureInfo& measure) { return measure.name == name; });
  return found == kMeasureTable.end() ? nullptr : &*found;
}

std::span<const AcceptanceCriteria> preset_criteria() { return kPresets; }

const AcceptanceCriteria* find_preset(std::string_view name) {
  const auto found = std::find_if(kPresets.begin(), kPresets.end(),
                                  [name](const AcceptanceCriteria& preset) { return preset.name == name; });
  return found == kPresets.end() ? nullptr : &*found;
}

void check_criterion(const AcceptanceCriterion& c) {
  const auto refuse = [&](const std::string& why) {
    throw OptionError("the criterion for " + std::string(info_of(c.measure).name) + " " + why);
  };
  if (!c.warn && !c.fail) refuse("has no limit; give warn, fail or both");
  if ((c.warn && !std::isfinite(*c.warn)) || (c.fail && !std::isfinite(*c.fail)))
    refuse("has a limit that is no number");
  for (const auto& [verdict, limit] : {std::pair("warns", c.warn), std::pair("fails", c.fail)}) {
    if (!limit || !is_out_of_reach(*limit, info_of(c.measure))) continue;
    const double best = info_of(c.measure).best;
    refuse(std::string(verdict) + " by the limit " + short_text(*limit) +
           ", which no element meets: the best value is " + short_text(best));
  }
  if (!(c.allowed_percent >= 0 && c.allowed_percent <= 100)) refuse("allows a percentage that is not in 0 to 100");
  if (!c.warn || !c.fail) return;
  const bool larger = info_of(c.measure).larger_is_better;
  if (larger ? *c.warn < *c.fail : *c.warn > *c.fail) {
    refuse(std::string("warns later than it fails: warn must be at ") + (larger ? "least" : "most") + " fail");
  }
}

const char* to_string(Verdict verdict) { return name_of(verdict, {"pass", "warn", "fail"}); }

}  // namespace tetune
