// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "ptxsim/global_memory.hpp"
#include "ptxsim/problems.hpp"
#include "ptxsim/warp.hpp"

namespace tetune::ptxsim {
namespace {

/// One access of one lane.
struct Request {
  Warp& warp;
  u32 lane;
  u64 address;
  u32 bytes;
  Access access;
  const Instruction& instruction;

  const char* verb() const { return access == Access::read ? "read" : "write"; }
  void fail(Fault fault, const std::string& what) const {
    problems().report(fault, &instruction, [&] {
      return formatted("%s of %u bytes at %llx %s\n  %s\n  %s", verb(), bytes, static_cast<unsigned long long>(address),
                       what.c_str(), thread_name(warp, lane).c_str(), place_of(instruction).c_str());
    });
  }
  bool is_strong() const { return instruction.strong || access == Access::atomic; }
};

/// The memory that accesses which failed a check read and write.
char* memory_of_failed_accesses() {
  alignas(64) static char memory[256];
  return memory;
}

void check_race(const Request& r, ByteHistory* history, const Accessor& accessor, const char* memory) {
  const Race race = record(history, r.bytes, accessor, r.access);
  if (race.found) r.fail(Fault::race, formatted("is a race: %s memory %s", memory, race.text));
}

void check_written(const Request& r, GlobalMemory::Region& region, const GlobalMemory::Buffer& buffer) {
  u8* const written = &region.written[r.address - region.base];
  if (r.access != Access::write && std::memchr(written, 0, r.bytes) != nullptr) {
    r.fail(Fault::unwritten, formatted("that was never written, at byte %llu of a buffer of %llu",
                                       static_cast<unsigned long long>(r.address - buffer.begin),
                                       static_cast<unsigned long long>(buffer.end - buffer.begin)));
  }
  if (r.access != Access::read) std::memset(written, 1, r.bytes);
}

char* resolve_global(const Request& r) {
  GlobalMemory::Region* const region = global_memory().find(r.address);
  if (region == nullptr) {
    r.fail(Fault::outside_memory, "is outside the memory of the device");
    return memory_of_failed_accesses();
  }
  const GlobalMemory::Buffer& buffer = region->buffer_at(r.address);
  if (!buffer.in_use || r.address < buffer.begin || r.address + r.bytes > buffer.end) {
    r.fail(Fault::outside_buffer,
           formatted("is outside a buffer of %llu bytes at %llx%s",
                     static_cast<unsigned long long>(buffer.end - buffer.begin),
                     static_cast<unsigned long long>(buffer.begin), buffer.in_use ? "" : " that is not in use"));
    return memory_of_failed_accesses();
  }
  if (!region->written.empty()) check_written(r, *region, buffer);
  if (region->history != nullptr && !r.warp.launch->is_of_library) {
    const Block& block = *r.warp.block;
    check_race(r, region->history + (r.address - region->base),
               {global_epoch(r.warp.launch->number, block.epoch),
                thread_number(block.number, r.warp.thread_in_block(r.lane)), r.is_strong()},
               "global");
  }
  return reinterpret_cast<char*>(r.address);
}

char* resolve_shared(const Request& r) {
  Block& block = *r.warp.block;
  if (r.address + r.bytes > block.shared.size()) {
    r.fail(Fault::outside_shared, formatted("is outside the %zu bytes of shared memory", block.shared.size()));
    return memory_of_failed_accesses();
  }
  if (!block.history.empty() && !r.warp.launch->is_of_library) {
    check_race(r, &block.history[r.address], {block.epoch, r.warp.thread_in_block(r.lane), r.is_strong()}, "shared");
  }
  return &block.shared[r.address];
}

char* resolve_local(const Request& r) {
  const u32 end = r.warp.lanes[r.lane].stack_end;
  if (r.address + r.bytes > end) {
    r.fail(Fault::outside_stack, formatted("is outside the %u bytes of the stack", end));
    return memory_of_failed_accesses();
  }
  return r.warp.stack(r.lane) + r.address;
}

char* resolve_parameter(const Request& r) {
  Launch& launch = *r.warp.launch;
  if (r.access != Access::read || r.address + r.bytes > launch.kernel->parameter_bytes) {
    r.fail(Fault::outside_parameters, "is outside the parameters of the kernel");
    return memory_of_failed_accesses();
  }
  return &launch.parameters[r.address];
}

Space space_of_tag(u64 tag) {
  return tag == kSharedTag      ? Space::shared
         : tag == kLocalTag     ? Space::local
         : tag == kParameterTag ? Space::parameter
                                : Space::global;
}

}  // namespace

char* resolve_any(Warp& warp, u32 lane, u64 address, u32 bytes, Access access, const Instruction& instruction,
                  Space& space) {
  space = instruction.space;
  if (space == Space::generic) {
    space = space_of_tag(address & kTagMask);
    if (space != Space::global) address &= ~kTagMask;
  }
  const Request request{warp, lane, address, bytes, access, instruction};
  if ((address & (bytes - 1)) != 0) request.fail(Fault::misaligned, "is misaligned");
  switch (space) {
    case Space::global:
      return resolve_global(request);
    case Space::shared:
      return resolve_shared(request);
    case Space::parameter:
      return resolve_parameter(request);
    default:
      return resolve_local(request);
  }
}

}  // namespace tetune::ptxsim
