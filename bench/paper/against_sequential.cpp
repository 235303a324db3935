// SPDX-License-Identifier: Apache-2.0
// One mesh through the sequential method and through ours, as JSON on standard output:
//   bench_paper MESH --what flips|preserve|gradient --runs N --threads T [--sequential 0|1]
// A time is given only for a result that is valid.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/connect.hpp"
#include "core/upload.hpp"
#include "par/cpu.hpp"
#include "reference/alexa.hpp"
#include "tetune/tetune.hpp"

namespace {

using Json = nlohmann::ordered_json;
using tetune::TetMesh;

struct Arguments {
  std::string mesh, what = "flips";
  int runs = 1;
  int threads = 0;
  bool sequential = true;
};

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v.size() % 2 == 1 ? v[v.size() / 2] : 0.5 * (v[v.size() / 2 - 1] + v[v.size() / 2]);
}

Json quality_json(const TetMesh& mesh) {
  const tetune::Quality q = tetune::quality(mesh);
  return {{"tets", q.tets},       {"phi_min", q.dihedral_min}, {"phi_5", q.dihedral_5},
          {"eta_max", q.eta_max}, {"eta_95", q.eta_95},        {"eta_sum", q.eta_sum}};
}

Json result_json(const TetMesh& before, const TetMesh& after, const std::vector<double>& seconds) {
  const bool valid = tetune::validate(after).ok();
  Json json = {{"valid", valid}, {"quality", quality_json(after)}};
  json["seconds"] = valid ? Json(median(seconds)) : Json(nullptr);
  json["all_seconds"] = seconds;
  const tetune::Comparison c = tetune::compare(before, after);
  json["distance_new_to_old"] = c.new_to_old;
  json["distance_old_to_new"] = c.old_to_new;
  return json;
}

/// The mesh along the space-filling curve: what locality alone is worth to the sequential method.
TetMesh sorted(const TetMesh& mesh) {
  using namespace tetune;
  WorkMesh<par::Cpu> work = upload_mesh<par::Cpu>(mesh);
  sort_mesh<par::Cpu>(par::Cpu(0), work, nullptr);
  TetMesh result;
  for (const Point& p : work.points.download()) result.points.push_back({p.x, p.y, p.z});
  for (const Tet& t : work.tet2vertex.download()) result.tets.push_back({t[0], t[1], t[2], t[3]});
  result.tet_tags = work.tet_tags.download();
  result.point_tags.assign(result.points.size(), 0);
  return result;
}

Json sequential_flips(const TetMesh& mesh, int runs) {
  std::vector<double> seconds;
  TetMesh last;
  tetune::reference::FlipResult result;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    const auto start = std::chrono::steady_clock::now();
    result = tetune::reference::flip_in_order(last);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  Json json = result_json(mesh, last, seconds);
  json["flips_2_3"] = result.flips23;
  json["flips_3_2"] = result.flips32;
  return json;
}

Json ours(const TetMesh& mesh, const tetune::Options& options, int runs) {
  std::vector<double> seconds;
  std::vector<double> flip_seconds;
  TetMesh last;
  tetune::Report report;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    report = tetune::optimize(last, options);
    seconds.push_back(report.seconds);
    double flips = 0;
    for (const auto& pass : report.flip_passes) flips += pass.seconds;
    flip_seconds.push_back(flips);
  }
  Json json = result_json(mesh, last, seconds);
  json["threads"] = report.threads;
  json["flip_seconds"] = median(flip_seconds);
  json["flips_2_3"] = report.flips23;
  json["flips_3_2"] = report.flips32;
  json["stopped"] = tetune::to_string(report.stop);
  Json norms = Json::array();
  for (const auto& s : report.sweeps) norms.push_back(s.gradient_norm);
  json["gradient_norm"] = norms;
  return json;
}

Json alexa(const TetMesh& mesh, int runs) {
  std::vector<double> seconds;
  TetMesh last;
  tetune::reference::AlexaReport report;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    report = tetune::reference::optimize(last);
    seconds.push_back(report.seconds);
  }
  Json json = result_json(mesh, last, seconds);
  json["finished"] = report.finished;
  json["flip_seconds"] = report.flip_seconds;
  json["descent_seconds"] = report.descent_seconds;
  json["projection_seconds"] = report.projection_seconds;
  Json norms = Json::array();
  for (const auto& i : report.iterations) norms.push_back(i.gradient_norm);
  json["gradient_norm"] = norms;
  return json;
}

Arguments parse(int argc, char** argv) {
  Arguments a;
  if (argc < 2) throw tetune::OptionError("usage: bench_paper MESH --what flips|preserve|gradient ...");
  a.mesh = argv[1];
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--what") a.what = argv[i + 1];
    if (name == "--runs") a.runs = std::max(1, std::atoi(argv[i + 1]));
    if (name == "--threads") a.threads = std::atoi(argv[i + 1]);
    if (name == "--sequential") a.sequential = std::atoi(argv[i + 1]) != 0;
  }
  return a;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments a = parse(argc, argv);
    const TetMesh mesh = tetune::read_mesh(a.mesh);
    Json json = {{"mesh", a.mesh}, {"what", a.what}, {"runs", a.runs}, {"input", quality_json(mesh)}};
    tetune::Options options;
    options.max_ring = 3;  // the flips of the paper
    if (a.what == "flips") {
      options.max_iterations = 0;
      if (a.sequential) {
        json["sequential"] = sequential_flips(mesh, a.runs);
        json["sequential_sorted"] = sequential_flips(sorted(mesh), a.runs);
      }
    } else {
      if (a.what == "gradient") {
        options.relocation = tetune::Relocation::gradient;
        options.termination = tetune::Termination::paper;
      }
      if (a.sequential) json["sequential"] = alexa(mesh, a.runs);
    }
    options.threads = 1;
    json["ours_one_thread"] = ours(mesh, options, a.runs);
    options.threads = a.threads;
    json["ours"] = ours(mesh, options, a.runs);
    std::printf("%s\n", json.dump(2).c_str());
  } catch (const tetune::Error& e) {
    std::fprintf(stderr, "bench_paper: %s\n", e.what());
    return 2;
  }
}
