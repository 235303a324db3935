// SPDX-License-Identifier: Apache-2.0
// Runs one experiment of the paper on one mesh and prints the result as JSON:
//   bench_paper MESH --what flips|no-flips|descended|preserve|slide [--runs N] [--threads T] [--device cpu|cuda]
// flips: the sequential queue and the parallel flips. no-flips, descended: the method of Alexa (2019) with its two
// termination criteria. preserve, slide: optimize(), as in Tables 2 and 3 of the paper. A time is printed only for a
// valid result. Runs on one thread are measured in processor time, which other programs hardly affect; runs on several
// threads in wall time.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <vector>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/sort_mesh.hpp"
#include "mesh/work_mesh.hpp"
#include "reference/alexa.hpp"
#include "tetune/tetune.hpp"

namespace {

using Json = nlohmann::ordered_json;
using tetune::TetMesh;

struct Arguments {
  std::string mesh, experiment = "flips";
  int runs = 1;
  int threads = 0;
  tetune::Device device = tetune::Device::cpu;
};

/// The objective, features and flips of the paper: the base of all runs except those with the default options.
tetune::Options paper_settings() {
  tetune::Options options;
  options.energy = tetune::Energy::harmonic;
  options.feature_angle = 180;
  options.max_ring = 3;
  return options;
}

/// paper_settings() with the relocation and the termination of the paper (Alg. 1, Sect. 4.5).
tetune::Options paper_relocation() {
  tetune::Options options = paper_settings();
  options.relocation = tetune::Relocation::gradient;
  options.termination = tetune::Termination::paper;
  return options;
}

/// Processor time and wall time since its construction, in seconds.
class Stopwatch {
 public:
  double processor_seconds() const { return static_cast<double>(std::clock() - processor_start_) / CLOCKS_PER_SEC; }
  double wall_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
  }

 private:
  std::clock_t processor_start_ = std::clock();
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
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
  json["vertices_to_old"] = c.vertices_to_old;
  json["distance_new_to_old"] = c.new_to_old;
  json["distance_old_to_new"] = c.old_to_new;
  return json;
}

/// The mesh sorted along the space-filling curve, to measure the effect of locality on the sequential method.
TetMesh sorted(const TetMesh& mesh) {
  using namespace tetune;
  WorkMesh<backend::Cpu> work = upload_mesh(backend::Cpu(1), mesh);
  sort_mesh(backend::Cpu(0), work);
  TetMesh result;
  for (const Point& p : work.points.download()) result.points.push_back({p.x, p.y, p.z});
  for (const Tet& t : work.tet2vertex.download()) result.tets.push_back({t[0], t[1], t[2], t[3]});
  for (const Index t : work.tet2original.download()) result.tet_tags.push_back(span_of(mesh.tet_tags)[t]);
  result.point_tags.assign(result.points.size(), 0);
  return result;
}

Json sequential_flips(const TetMesh& mesh, int runs) {
  std::vector<double> seconds;
  TetMesh last;
  tetune::reference::FlipResult result;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    const Stopwatch watch;
    result = tetune::reference::flip_in_order(last);
    seconds.push_back(watch.processor_seconds());
  }
  Json json = result_json(mesh, last, seconds);
  json["flips_2_3"] = result.flips23;
  json["flips_3_2"] = result.flips32;
  return json;
}

Json run_optimize(const TetMesh& mesh, const tetune::Options& options, int runs) {
  std::vector<double> seconds, wall_seconds, flip_seconds;
  TetMesh last;
  tetune::Report report;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    const Stopwatch watch;
    report = tetune::optimize(last, options);
    wall_seconds.push_back(watch.wall_seconds());
    seconds.push_back(options.threads == 1 ? watch.processor_seconds() : watch.wall_seconds());
    double flips = 0;
    for (const auto& pass : report.flip_passes) flips += pass.seconds;
    flip_seconds.push_back(flips);
  }
  Json json = result_json(mesh, last, seconds);
  json["clock_seconds"] = median(wall_seconds);
  json["threads"] = report.threads;
  json["flip_seconds"] = median(flip_seconds);
  json["flips_2_3"] = report.flips23;
  json["flips_3_2"] = report.flips32;
  json["stopped"] = tetune::to_string(report.stop);
  Json norms = Json::array();
  Json energies = Json::array();
  for (const auto& s : report.sweeps) {
    norms.push_back(s.gradient_norm);
    energies.push_back(s.energy_before - s.decrease);
  }
  json["gradient_norm"] = norms;
  json["energy"] = energies;
  return json;
}

Json run_alexa(const TetMesh& mesh, const TetMesh& before, tetune::reference::AlexaEnd end, int runs) {
  std::vector<double> seconds;
  TetMesh last;
  tetune::reference::AlexaReport report;
  for (int r = 0; r < runs; ++r) {
    last = mesh;
    const Stopwatch watch;
    report = tetune::reference::optimize(last, end);
    seconds.push_back(watch.processor_seconds());
  }
  Json json = result_json(before, last, seconds);
  json["finished"] = report.finished;
  json["flip_seconds"] = report.flip_seconds;
  json["descent_seconds"] = report.descent_seconds;
  json["projection_seconds"] = report.projection_seconds;
  Json norms = Json::array();
  Json energies = Json::array();
  for (const auto& i : report.iterations) {
    norms.push_back(i.gradient_norm);
    energies.push_back(i.energy);
  }
  json["gradient_norm"] = norms;
  json["energy"] = energies;
  return json;
}

Json run(const TetMesh& mesh, const Arguments& a) {
  using tetune::reference::AlexaEnd;
  Json json = {{"mesh", a.mesh}, {"what", a.experiment}, {"runs", a.runs}, {"input", quality_json(mesh)}};
  if (a.experiment == "no-flips") {
    json["sequential"] = run_alexa(mesh, mesh, AlexaEnd::no_flips, a.runs);
    json["sequential_sorted"] = run_alexa(sorted(mesh), mesh, AlexaEnd::no_flips, a.runs);
    return json;
  }
  if (a.experiment == "descended") {
    json["sequential_sorted"] = run_alexa(sorted(mesh), mesh, AlexaEnd::descended, 1);
    return json;
  }
  const auto on_device = [&a](tetune::Options options) {
    options.device = a.device;
    if (a.device == tetune::Device::cpu) options.threads = a.threads;
    return options;
  };
  tetune::Options options = paper_settings();
  if (a.experiment == "flips") {
    options.max_iterations = 0;
    json["sequential"] = sequential_flips(mesh, a.runs);
    json["sequential_sorted"] = sequential_flips(sorted(mesh), a.runs);
  } else if (a.experiment == "preserve" || a.experiment == "slide") {
    const auto boundary = a.experiment == "slide" ? tetune::Boundary::slide : tetune::Boundary::preserve;
    options.boundary = boundary;
    tetune::Options paper = paper_relocation();
    paper.boundary = boundary;
    json["letter"] = run_optimize(mesh, on_device(paper), 1);
    tetune::Options defaults;
    defaults.boundary = boundary;
    json["defaults"] = run_optimize(mesh, on_device(defaults), a.runs);
  } else {
    throw tetune::OptionError("no such experiment: " + a.experiment);
  }
  json["ours"] = run_optimize(mesh, on_device(options), a.runs);
  options.threads = 1;
  json["ours_one_thread"] = run_optimize(mesh, options, a.runs);
  return json;
}

Arguments parse(int argc, char** argv) {
  Arguments a;
  if (argc < 2) throw tetune::OptionError("usage: bench_paper MESH --what EXPERIMENT ...");
  a.mesh = argv[1];
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const std::string value = argv[i + 1];
    if (name == "--what") a.experiment = value;
    if (name == "--runs") a.runs = std::max(1, std::atoi(value.c_str()));
    if (name == "--threads") a.threads = std::atoi(value.c_str());
    if (name == "--device") a.device = value == "cuda" ? tetune::Device::cuda : tetune::Device::cpu;
  }
  return a;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments a = parse(argc, argv);
    std::printf("%s\n", run(tetune::read_mesh(a.mesh), a).dump(2).c_str());
  } catch (const tetune::Error& e) {
    std::fprintf(stderr, "bench_paper: %s\n", e.what());
    return 2;
  }
}
