// SPDX-License-Identifier: Apache-2.0
// From file to file on a number of threads, measured or modeled (machine_model.hpp):
//
//   bench_model real|model|serial THREADS MESH OUT [OPTION=VALUE ...]
//
// `serial` gives the parts of the run that are not loops. Prints one line of JSON: seconds of each phase.
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "machine_model.hpp"
#include "phases/progress/phase_timer.hpp"
#include "tetune/option_table.hpp"
#include "tetune/tetune.hpp"

namespace {

std::optional<tetune::scaling::MachineModel> machine;

}  // namespace

tetune::backend::ProcessorModel* tetune::backend::processor_model() noexcept { return machine ? &*machine : nullptr; }

int main(int argc, char** argv) {
  using namespace tetune;
  const std::string mode = argc < 5 ? "" : argv[1];
  if (mode != "real" && mode != "model" && mode != "serial") {
    std::fprintf(stderr, "usage: bench_model real|model|serial THREADS MESH OUT [OPTION=VALUE ...]\n");
    return 2;
  }
  using Loops = scaling::MachineModel::Loops;
  if (mode != "real") machine.emplace(mode == "serial" ? Loops::free : Loops::scheduled, scaling::ThreadCosts{});
  try {
    Options options;
    for (int i = 5; i < argc; ++i) {
      const std::string argument = argv[i];
      const auto equals = argument.find('=');
      set_option(options, argument.substr(0, equals), argument.substr(equals + 1));
    }
    options.threads = std::atoi(argv[2]);
    const auto start = PhaseTimer::SteadyClock::now();
    TetMesh mesh = read_mesh(argv[3], nullptr, options.threads);
    const double read = PhaseTimer::seconds_since(start);
    const Report report = optimize(mesh, options);
    const auto store = PhaseTimer::SteadyClock::now();
    write_mesh(argv[4], mesh, options.threads);
    std::printf("{\"read\": %.4f, ", read);
    for (const PhaseTime& time : report.phases) std::printf("\"%s\": %.4f, ", time.phase.c_str(), time.seconds);
    std::printf("\"optimize\": %.4f, \"write\": %.4f, \"whole\": %.4f, \"energy\": %.17g}\n", report.seconds,
                PhaseTimer::seconds_since(store), PhaseTimer::seconds_since(start), report.energy_after);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_model: %s\n", error.what());
    return 1;
  }
  return 0;
}
