// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/launch.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <random>

#include "ptxsim/problems.hpp"
#include "ptxsim/reports.hpp"
#include "ptxsim/settings.hpp"
#include "ptxsim/warp.hpp"

namespace tetune::ptxsim {
namespace {

// Limits of all architectures from sm_75.
constexpr u64 kMaxThreads = 1024, kMaxGridYZ = 65535, kMaxShared = 48 * 1024, kMaxParameters = 4096;

/// Instructions of a warp before the next one runs.
constexpr u64 kTurn = 100000, kMaxRandomTurn = 200;

u32 launches = 0;

/// Registers and stacks of warps that have ended, for others.
class WarpMemory {
 public:
  void give(Warp& w, u32 rows) {
    if (!registers_.empty() && registers_.back().rows >= rows) {
      w.registers = registers_.back().memory;
      w.register_rows = registers_.back().rows;
      registers_.pop_back();
    } else {
      const std::size_t bytes = std::size_t{rows} * kLanes * sizeof(u64);
      w.registers = static_cast<u64*>(std::aligned_alloc(64, bytes));
      w.register_rows = rows;
      std::memset(w.registers, 0, bytes);
    }
    if (stacks_.empty()) stacks_.push_back(new_stacks());
    w.stacks = stacks_.back();
    stacks_.pop_back();
  }
  void take_back(const Warp& w) {
    registers_.push_back({w.registers, w.register_rows});
    stacks_.push_back(w.stacks);
  }
  /// The largest registers last, where they are taken from.
  void sort() {
    std::sort(registers_.begin(), registers_.end(), [](const auto& a, const auto& b) { return a.rows < b.rows; });
  }

 private:
  struct Registers {
    u64* memory;
    u32 rows;
  };
  static char* new_stacks() {
    void* const memory = mmap(nullptr, kLanes * kStackStride, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) fatal("out of memory for stacks");
    return static_cast<char*>(memory);
  }

  std::vector<Registers> registers_;
  std::vector<char*> stacks_;
};

WarpMemory& warp_memory() {
  static WarpMemory instance;
  return instance;
}

/// The registers of a function and of the deepest calls below it.
u32 registers_below(const Function& f, u32 depth = 0) {
  static std::map<const Function*, u32> known;
  if (const auto found = known.find(&f); found != known.end()) return found->second;
  if (depth > 30) fatal("recursion in " + f.name);
  u32 most = 0;
  const std::vector<Instruction>& code = f.module->code;
  for (u32 at = f.begin; at < code.size() && code[at].function == &f; ++at) {
    const Function* const callee = code[at].callee;
    if (callee != nullptr && callee->is_defined) most = std::max(most, registers_below(*callee, depth + 1));
  }
  return known[&f] = f.registers + most;
}

void start_warp(Warp& w, Block& block, Launch& launch, u32 id) {
  const Function& kernel = *launch.kernel;
  w.block = &block;
  w.launch = &launch;
  w.id = id;
  w.code = kernel.module->code.data();
  w.constants = kernel.module->constants.data();
  warp_memory().give(w, registers_below(kernel));
  for (u32 l = 0; l < kLanes; ++l) {
    const u32 thread = w.thread_in_block(l);
    if (thread >= block.running) break;
    Lane& lane = w.lanes[l];
    lane.state = LaneState::running;
    lane.thread[0] = thread % launch.block.x;
    lane.thread[1] = thread / launch.block.x % launch.block.y;
    lane.thread[2] = thread / launch.block.x / launch.block.y;
    lane.pc = kernel.begin;
    lane.stack_end = kernel.frame_bytes;
    w.not_ended |= LaneMask{1} << l;
  }
}

std::unique_ptr<Block> start_block(Launch& launch, u32 number, std::size_t shared_bytes) {
  auto block = std::make_unique<Block>();
  const dim3 grid = launch.grid;
  block->number = number;
  block->index[0] = number % grid.x;
  block->index[1] = number / grid.x % grid.y;
  block->index[2] = number / grid.x / grid.y;
  block->shared.assign(shared_bytes, static_cast<char>(0xfb));
  if (settings().races) block->history.assign(shared_bytes, {});
  block->running = launch.block.x * launch.block.y * launch.block.z;
  for (u32 id = 0; id * kLanes < block->running; ++id) {
    block->warps.push_back(std::make_unique<Warp>());
    start_warp(*block->warps.back(), *block, launch, id);
  }
  return block;
}

/// The blocks of a launch, some at the same time.
class Execution {
 public:
  Execution(Launch& launch, std::size_t shared_bytes) : launch_(launch), shared_bytes_(shared_bytes) {}

  void run() {
    const u32 blocks = launch_.grid.x * launch_.grid.y * launch_.grid.z;
    while (next_ < blocks || !resident_.empty()) {
      while (next_ < blocks && resident_.size() < settings().resident_blocks) {
        resident_.push_back(start_block(launch_, next_++, shared_bytes_));
      }
      if (!run_each_warp()) {
        report_endless_wait();
        return;
      }
      remove_ended_blocks();
    }
  }

 private:
  bool run_each_warp() {
    std::vector<Warp*> warps;
    for (const auto& block : resident_) {
      for (const auto& w : block->warps) warps.push_back(w.get());
    }
    static std::mt19937_64 random(settings().seed);
    const bool shuffled = settings().seed != 0;
    if (shuffled) std::shuffle(warps.begin(), warps.end(), random);
    bool any = false;
    for (Warp* const w : warps) {
      if (w->not_ended != 0) any |= ptxsim::run(*w, shuffled ? 1 + random() % kMaxRandomTurn : kTurn);
    }
    return any;
  }

  void report_endless_wait() {
    problems().report(Fault::endless_wait, launch_.kernel, [this] {
      for (const auto& w : resident_.front()->warps) {
        for (u32 l = 0; l < kLanes; ++l) {
          if (w->lanes[l].state == LaneState::ended) continue;
          return "threads wait for others for ever\n  " + thread_name(*w, l) + "\n  " +
                 place_of(w->code[w->lanes[l].pc]);
        }
      }
      return std::string("threads wait for ever");
    });
  }

  void remove_ended_blocks() {
    const auto ended = std::remove_if(resident_.begin(), resident_.end(), [this](const auto& block) {
      if (block->running > 0) return false;
      for (const auto& w : block->warps) {
        launch_.counts.longest_warp = std::max(launch_.counts.longest_warp, w->instructions);
        warp_memory().take_back(*w);
      }
      return true;
    });
    resident_.erase(ended, resident_.end());
  }

  Launch& launch_;
  std::size_t shared_bytes_;
  u32 next_ = 0;
  std::vector<std::unique_ptr<Block>> resident_;
};

void check_limits(const Function& kernel, dim3 grid, dim3 block, std::size_t shared_bytes) {
  const u64 threads = u64{block.x} * block.y * block.z;
  const u64 most_threads = kernel.max_threads != 0 ? kernel.max_threads : kMaxThreads;
  if (threads == 0 || threads > most_threads || u64{grid.x} * grid.y * grid.z == 0 || grid.y > kMaxGridYZ ||
      grid.z > kMaxGridYZ || shared_bytes > kMaxShared || kernel.parameter_bytes > kMaxParameters) {
    fatal(formatted("launch of %u x %u x %u blocks of %llu threads, %zu bytes shared memory, %u of parameters: %s",
                    grid.x, grid.y, grid.z, static_cast<unsigned long long>(threads), shared_bytes,
                    kernel.parameter_bytes, demangled(kernel.name).c_str()));
  }
}

}  // namespace

u32 launch_count() { return launches; }

void run_kernel(const Function& kernel, dim3 grid, dim3 block, void** arguments, std::size_t dynamic_shared_bytes) {
  const std::size_t shared_bytes = kernel.shared_bytes + dynamic_shared_bytes;
  check_limits(kernel, grid, block, shared_bytes);
  Launch launch;
  launch.kernel = &kernel;
  launch.number = ++launches;
  launch.is_of_library = kernel.name.find("3cub") != std::string::npos;
  launch.grid = grid;
  launch.block = block;
  launch.parameters.resize(kernel.parameter_bytes + 16);
  for (std::size_t k = 0; k < kernel.parameters.size(); ++k) {
    const Slot& parameter = kernel.parameters[k];
    std::memcpy(&launch.parameters[parameter.offset], arguments[k], parameter.bytes);
  }
  launch.counts.blocks = u64{grid.x} * grid.y * grid.z;
  launch.counts.threads = launch.counts.blocks * block.x * block.y * block.z;
  launch.counts.stack_bytes = kernel.frame_bytes;
  launch.profile = profile_of(*kernel.module);
  Execution(launch, shared_bytes).run();
  warp_memory().sort();
  write_trace(launch);
}

}  // namespace tetune::ptxsim
