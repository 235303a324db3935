// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/reports.hpp"

#include <cstdio>
#include <cstdlib>

#include "ptxsim/settings.hpp"

namespace tetune::ptxsim {
namespace {

std::FILE* open(const std::string& path) {
  std::FILE* const file = std::fopen(path.c_str(), "w");
  if (file == nullptr) fatal("cannot write " + path);
  return file;
}

std::FILE* new_trace() {
  std::FILE* const file = open(settings().trace);
  std::fprintf(file,
               "launch\tname\tbytes\tblocks\tthreads\twarp_instructions\tlane_instructions\tlongest_warp\tstack_bytes\t"
               "requests\tsectors\tdistinct_sectors");
  for (const char* const prefix : {"warps", "lanes"}) {
    for (u32 k = 0; k < kKinds; ++k) std::fprintf(file, "\t%s_%s", prefix, name_of(static_cast<Kind>(k)));
  }
  std::fprintf(file, "\n");
  return file;
}

void write_line(u32 number, const std::string& name, u64 bytes, const LaunchCounts& c) {
  if (settings().trace.empty()) return;
  static std::FILE* const file = new_trace();
  std::fprintf(file, "%u\t%s\t%llu", number, name.c_str(), static_cast<unsigned long long>(bytes));
  for (const u64 count : {c.blocks, c.threads, c.warp_instructions, c.lane_instructions, c.longest_warp, c.stack_bytes,
                          c.requests, c.sectors, c.distinct_sectors}) {
    std::fprintf(file, "\t%llu", static_cast<unsigned long long>(count));
  }
  for (const auto& counts : {c.warp_instructions_of, c.lane_instructions_of}) {
    for (u32 k = 0; k < kKinds; ++k) std::fprintf(file, "\t%llu", static_cast<unsigned long long>(counts[k]));
  }
  std::fprintf(file, "\n");
  std::fflush(file);
}

using Profiles = std::map<const Module*, std::vector<u64>>;
Profiles& profiles() {
  static auto* const instance = new Profiles;
  return *instance;
}

void write_profile() {
  std::map<std::pair<std::string, u32>, u64> by_line;
  for (const auto& [module, counts] : profiles()) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const Instruction& instruction = module->code[i];
      const auto file = module->files.find(instruction.file);
      if (counts[i] != 0 && file != module->files.end()) by_line[{file->second, instruction.line}] += counts[i];
    }
  }
  std::FILE* const file = open(settings().profile);
  for (const auto& [place, count] : by_line) {
    std::fprintf(file, "%llu\t%s\t%u\n", static_cast<unsigned long long>(count), place.first.c_str(), place.second);
  }
  std::fclose(file);
}

}  // namespace

void write_trace(const Launch& launch) { write_line(launch.number, demangled(launch.kernel->name), 0, launch.counts); }

void write_transfer(const char* name, u64 bytes) { write_line(0, name, bytes, {}); }

std::vector<u64>* profile_of(const Module& module) {
  if (settings().profile.empty()) return nullptr;
  if (profiles().empty()) std::atexit(write_profile);
  std::vector<u64>& counts = profiles()[&module];
  counts.resize(module.code.size());
  return &counts;
}

}  // namespace tetune::ptxsim
