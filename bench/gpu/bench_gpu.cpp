// SPDX-License-Identifier: Apache-2.0
// Compares the GPU with the CPU, for bench/gpu/run: prints one line of JSON per measurement.
//   bench_gpu ceilings                       the device and its peak rates
//   bench_gpu parity [FILE ...]              both backends on small meshes: exit code 1 if they differ
//   bench_gpu small                          small meshes that run all kernels, for compute-sanitizer
//   bench_gpu mesh TETS|FILE RUNS            times of valid results; TETS: the approximate size of a generated mesh
//   bench_gpu count TETS|FILE fixed|preserve|slide fast|standard|best
//                                            one run alone, compared with the CPU's: for bench/gpu/model and for
//                                            profilers
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

#include "bench/gpu/device.hpp"
#include "reference/generate.hpp"
#include "tetune/tetune.hpp"

namespace tetune::gpu_bench {
namespace {

/// A JSON object.
class Json {
 public:
  Json& add(const char* key, const std::string& json) {
    text_ += (text_.empty() ? "\"" : ", \"") + std::string(key) + "\": " + json;
    return *this;
  }
  Json& text(const char* key, const std::string& value) {
    std::string quoted = "\"";
    for (const char c : value) quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    return add(key, quoted + "\"");
  }
  Json& number(const char* key, double value) { return add(key, digits(value)); }
  Json& numbers(const char* key, const std::vector<double>& values) {
    std::string list;
    for (const double v : values) list += (list.empty() ? "" : ", ") + digits(v);
    return add(key, "[" + list + "]");
  }
  std::string str() const { return "{" + text_ + "}"; }
  void print() const {
    std::printf("%s\n", str().c_str());
    std::fflush(stdout);
  }

 private:
  static std::string digits(double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.12g", value);
    return buffer;
  }
  std::string text_;
};

/// Reports a failed check: the program ends without printing times.
[[noreturn]] void fail(const std::string& what) { throw Error("FAILED: " + what); }

/// A cube of two regions after random flips, on which all kinds of flips apply, at the interface too.
TetMesh generated(double tets) {
  // One round of flips adds about one sixth of the tetrahedra.
  const int n = std::max(2, static_cast<int>(std::lround(std::cbrt(tets / 7))));
  TetMesh mesh = reference::lattice(n, 0.2);
  for (std::size_t t = mesh.tets.size() / 2; t < mesh.tets.size(); ++t) mesh.tet_tags[t] = 1;
  return reference::scrambled(std::move(mesh), 1);
}

TetMesh load_or_generate(const std::string& source) {
  char* end = nullptr;
  const double tets = std::strtod(source.c_str(), &end);
  return *end == '\0' && tets > 0 ? generated(tets) : read_mesh(source);
}

std::vector<double> flips_of(const Report& r) {
  std::vector<double> counts;
  for (const auto& kind : kOperationCounts) counts.push_back(static_cast<double>(r.*kind.count));
  return counts;
}

double energy_difference(const Report& a, const Report& b) {
  return std::fabs(a.energy_after - b.energy_after) / b.energy_after;
}

void check_valid(const TetMesh& mesh, const std::string& what) {
  const ValidationReport report = validate(mesh);
  if (!report.ok()) fail(what + " is invalid: " + report.message(false));
}

bool same_bits(const TetMesh& a, const TetMesh& b) {
  return a.tets == b.tets && a.points.size() == b.points.size() &&
         std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof a.points[0]) == 0;
}

void check_parity(const std::string& name, const TetMesh& mesh) {
  constexpr double kMaxDifference = 1e-9;
  const std::pair<Boundary, const char*> boundaries[] = {
      {Boundary::fixed, "fixed"}, {Boundary::preserve, "preserve"}, {Boundary::slide, "slide"}};
  const std::pair<Effort, const char*> efforts[] = {
      {Effort::fast, "fast"}, {Effort::standard, "standard"}, {Effort::best, "best"}};
  std::string failed;
  for (const auto& [boundary, boundary_name] : boundaries) {
    for (const auto& [effort, effort_name] : efforts) {
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      const std::string what = name + ", " + boundary_name + ", " + effort_name;
      options.device = Device::cpu;
      TetMesh on_cpu = mesh;
      const Report cpu = optimize(on_cpu, options);
      options.device = Device::cuda;
      TetMesh on_gpu = mesh;
      const Report gpu = optimize(on_gpu, options);
      TetMesh again = mesh;
      optimize(again, options);
      check_valid(on_cpu, what + ", by the CPU");
      check_valid(on_gpu, what + ", by the GPU");
      const double difference = energy_difference(gpu, cpu);
      const bool same_flips = flips_of(cpu) == flips_of(gpu);
      const bool repeats = same_bits(on_gpu, again);
      Json line;
      line.text("mesh", name).text("boundary", boundary_name).text("effort", effort_name);
      line.number("tets", static_cast<double>(mesh.tets.size())).number("energy_difference", difference);
      line.numbers("flips_cpu", flips_of(cpu)).numbers("flips_gpu", flips_of(gpu));
      line.add("same_flips", same_flips ? "true" : "false").add("same_bits_twice", repeats ? "true" : "false");
      line.print();
      if (!(difference <= kMaxDifference) || !same_flips || !repeats) failed += "\n  " + what;
    }
  }
  if (!failed.empty()) fail("CPU and GPU differ, or two runs on the GPU do:" + failed);
}

/// Medians of named times over several runs.
class Times {
 public:
  void add(const std::string& name, double seconds) { seconds_[name].push_back(seconds); }
  Json medians() const {
    Json json;
    for (const auto& [name, seconds] : seconds_) json.number(name.c_str(), median(seconds));
    return json;
  }

 private:
  std::map<std::string, std::vector<double>> seconds_;
};

/// Each pass and sweep ends with a download of its sums, which synchronizes: the times that the library measures on the
/// host are device times including launch gaps. The same holds for "load" and "store", host work and transfers, and for
/// "rings" together with "coloring".
void measure(const std::string& source, const TetMesh& mesh, int runs, bool flips_alone) {
  const auto tets = static_cast<double>(mesh.tets.size());
  Options options;
  options.max_iterations = flips_alone ? 0 : options.max_iterations;
  options.device = Device::cpu;
  TetMesh on_cpu = mesh;
  const Report cpu = optimize(on_cpu, options);
  check_valid(on_cpu, source + ", by the CPU");
  on_cpu = {};

  options.device = Device::cuda;
  const std::size_t free_before = free_bytes();
  std::size_t min_free = free_before;
  Context watch;
  watch.progress = [&min_free](const Progress&) {
    min_free = std::min(min_free, free_bytes());
    return true;
  };
  TetMesh first = mesh;
  const Report warm_up = optimize(first, options, watch);
  const auto peak = static_cast<double>(free_before - min_free);
  check_valid(first, source + ", by the GPU");

  Times phases;
  std::vector<double> seconds;
  std::vector<std::vector<double>> passes(warm_up.flip_passes.size());
  std::vector<std::vector<double>> sweeps(warm_up.sweeps.size());
  for (int run = 0; run < runs; ++run) {
    TetMesh again = mesh;
    const Report r = optimize(again, options);
    if (!same_bits(again, first)) fail(source + ": two runs on the GPU have different bits");
    seconds.push_back(r.seconds);
    for (const PhaseTime& p : r.phases) phases.add(p.phase, p.seconds);
    for (std::size_t i = 0; i < passes.size(); ++i) passes[i].push_back(r.flip_passes[i].seconds);
    for (std::size_t i = 0; i < sweeps.size(); ++i) sweeps[i].push_back(r.sweeps[i].seconds);
  }
  const auto medians = [](const std::vector<std::vector<double>>& all) {
    std::vector<double> values;
    for (const auto& one : all) values.push_back(median(one));
    return values;
  };
  Times cpu_phases;
  for (const PhaseTime& p : cpu.phases) cpu_phases.add(p.phase, p.seconds);
  Json line;
  line.text("mesh", source).add("flips_alone", flips_alone ? "true" : "false");
  line.number("tets", tets).number("vertices", static_cast<double>(mesh.points.size())).number("runs", runs);
  line.number("seconds", median(seconds)).add("phase_seconds", phases.medians().str());
  line.numbers("pass_seconds", medians(passes)).numbers("sweep_seconds", medians(sweeps));
  line.number("peak_bytes", peak).number("bytes_per_tet", peak / tets);
  line.number("cpu_threads", cpu.threads).number("cpu_seconds", cpu.seconds);
  line.add("cpu_phase_seconds", cpu_phases.medians().str());
  line.number("energy_difference", energy_difference(warm_up, cpu));
  line.numbers("flips_cpu", flips_of(cpu)).numbers("flips_gpu", flips_of(warm_up));
  if (!flips_alone) {
    Json stages;
    for (const auto& [name, time] : measure_stages(mesh, runs)) stages.number(name.c_str(), time);
    line.add("stage_seconds", stages.str());
  }
  line.print();
}

void run_on_gpu(TetMesh mesh, Options options) {
  options.device = Device::cuda;
  optimize(mesh, options);
  check_valid(mesh, "a mesh by the GPU");
}

void run_once_and_compare(const std::string& source, const std::string& boundary, const std::string& effort) {
  Options options;
  set_option(options, "boundary", boundary);
  set_option(options, "effort", effort);
  TetMesh on_gpu = load_or_generate(source);
  TetMesh on_cpu = on_gpu;
  const Report cpu = optimize(on_cpu, options);
  options.device = Device::cuda;
  const Report gpu = optimize(on_gpu, options);
  check_valid(on_gpu, "a mesh by the GPU");
  Json line;
  line.text("mesh", source).text("boundary", boundary).text("effort", effort);
  line.add("tets", std::to_string(on_cpu.tets.size())).add("sweeps", std::to_string(gpu.sweeps.size()));
  line.number("energy_difference", energy_difference(gpu, cpu));
  line.add("same_flips", flips_of(cpu) == flips_of(gpu) ? "true" : "false");
  line.number("cpu_seconds", cpu.seconds).number("cpu_threads", cpu.threads).print();
}

/// Small meshes and no restarts, as compute-sanitizer makes kernels slower by orders of magnitude.
void run_small() {
  const TetMesh mesh = generated(400);
  Options options;
  options.effort = Effort::best;
  options.restarts = 0;
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    options.boundary = boundary;
    options.max_deviation = boundary == Boundary::slide ? 0.01 : 0;
    run_on_gpu(mesh, options);
  }
  Options other;
  other.relocation = Relocation::gradient;
  other.energy = Energy::harmonic;
  run_on_gpu(mesh, other);
  Options untangling;
  untangling.untangle = true;
  TetMesh tangled = reference::lattice(4);
  tangled.points[tangled.points.size() / 2][0] += 0.375;  // beyond its neighbors
  run_on_gpu(std::move(tangled), untangling);
  Json().add("valid", "true").print();
}

void print_ceilings() {
  const Card c = card();
  Json line;
  line.text("card", c.name).number("compute_capability", c.major + 0.1 * c.minor).number("processors", c.processors);
  line.number("memory_bytes", static_cast<double>(c.memory));
  line.number("free_bytes", static_cast<double>(c.free_memory));
  line.number("driver_cuda", c.driver / 1000 + 0.01 * (c.driver % 1000));
  line.number("toolkit_cuda", c.runtime / 1000 + 0.01 * (c.runtime % 1000));
  const Ceilings m = measure_ceilings();
  line.number("copy_gb_s", 1e-9 * m.copy_bytes).number("upload_gb_s", 1e-9 * m.upload_bytes);
  line.number("download_gb_s", 1e-9 * m.download_bytes).number("single_tflops", 1e-12 * m.single_flops);
  line.number("double_tflops", 1e-12 * m.double_flops).number("launch_us", 1e6 * m.launch_seconds);
  line.number("round_trip_us", 1e6 * m.round_trip_seconds).print();
}

/// Throws the DeviceError of the library if no GPU can be used.
void require_gpu() { run_on_gpu(reference::lattice(1), {}); }

int usage() {
  std::fprintf(stderr,
               "usage: bench_gpu ceilings | parity [FILE ...] | small | mesh TETS|FILE RUNS |\n"
               "       count TETS|FILE fixed|preserve|slide fast|standard|best\n");
  return 2;
}

int run(const std::vector<std::string>& args) {
  const std::string command = args.empty() ? "" : args[0];
  const std::map<std::string, std::size_t> arguments{{"ceilings", 1}, {"small", 1}, {"mesh", 3}, {"count", 4}};
  const auto expected = arguments.find(command);
  if (command != "parity" && (expected == arguments.end() || expected->second != args.size())) return usage();
  const int runs = command == "mesh" ? std::atoi(args[2].c_str()) : 1;
  if (runs < 1) return usage();
  if (command != "count") require_gpu();
  if (command == "ceilings") print_ceilings();
  if (command == "small") run_small();
  if (command == "count") run_once_and_compare(args[1], args[2], args[3]);
  if (command == "mesh") {
    const TetMesh mesh = load_or_generate(args[1]);
    for (const bool flips_alone : {true, false}) measure(args[1], mesh, runs, flips_alone);
  }
  if (command == "parity") {
    check_parity("cube", generated(12000));
    for (std::size_t i = 1; i < args.size(); ++i) check_parity(args[i], read_mesh(args[i]));
  }
  return 0;
}

}  // namespace
}  // namespace tetune::gpu_bench

int main(int argc, char** argv) {
  try {
    return tetune::gpu_bench::run({argv + 1, argv + argc});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench_gpu: %s\n", e.what());
    return 1;
  }
}
