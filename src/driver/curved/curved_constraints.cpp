// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/curved_constraints.hpp"

#include <algorithm>
#include <iterator>
#include <optional>

#include "driver/curved/curved_skeleton.hpp"
#include "driver/curved/curved_slide.hpp"
#include "driver/parts/optimize_active.hpp"
#include "driver/report/dof_counts.hpp"
#include "driver/report/targets.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

/// CurvedSlide lists the features.
Options with_listed_features(Options options) {
  options.feature_angle = 180;
  return options;
}

}  // namespace

void count_curved_vertices(const TetMesh& mesh, const Options& options, Report& report) {
  const bool slides = options.boundary == Boundary::slide;
  std::optional<CurvedSlide> slide;
  if (slides) slide.emplace(mesh, options.feature_angle);
  const CurvedSkeleton skeleton(mesh, find_held(mesh, options), {}, slide ? &*slide : nullptr);
  Options linear = slides ? with_listed_features(options) : options;
  linear.max_deviation = 0;
  linear.untangle = false;
  Report counts = report_constraints(skeleton.mesh, linear);
  dof_counts(report) = dof_counts(counts);
}

std::vector<TargetReport> report_curved_targets(const TetMesh& result, const Options& options,
                                                const std::vector<Index>& vertex2original) {
  if (options.boundary != Boundary::slide || options.targets.empty()) {
    return report_targets(result, options, vertex2original);
  }
  TetMesh skeleton = result;
  CurvedSlide(result, options.feature_angle).constrain(skeleton);
  // The vertices that it makes required are corners of the surface, or periodic.
  std::vector<Index> required = result.required_vertices;
  sort_unique(required);
  std::set_difference(skeleton.required_vertices.begin(), skeleton.required_vertices.end(), required.begin(),
                      required.end(), std::back_inserter(skeleton.corners));
  sort_unique(skeleton.corners);
  skeleton.required_vertices = result.required_vertices;
  return report_targets(skeleton, with_listed_features(options), vertex2original);
}

}  // namespace tetune
