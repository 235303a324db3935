// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/fat_binary.hpp"

#include <cstring>

#include "ptxsim/settings.hpp"

namespace tetune::ptxsim {
namespace {

constexpr u32 kMagic = 0xba55ed50;
constexpr u16 kPtx = 1;  // the kind of an entry

template <class T>
T read(const char* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

u32 architecture_of(std::string_view ptx) {
  constexpr std::string_view kTarget = ".target sm_";
  const std::size_t at = ptx.find(kTarget);
  if (at == std::string_view::npos) fatal("the PTX is compressed: nvcc needs --no-compress");
  return static_cast<u32>(std::strtoul(ptx.data() + at + kTarget.size(), nullptr, 10));
}

struct RegisteredKernel {
  Module* module;
  std::string name;
};
std::map<const void*, RegisteredKernel>& kernels() {
  static std::map<const void*, RegisteredKernel> all;
  return all;
}

}  // namespace

void** register_fat_binary(void* wrapper) {
  // The wrapper: two numbers, then the address of the data. The data: a header, then entries, each with a header.
  const char* const data = read<const char*>(static_cast<const char*>(wrapper) + 8);
  if (read<u32>(data) != kMagic) fatal("the object file has no code for a GPU");
  auto* const module = new Module;  // used until the process ends
  const auto header_bytes = read<u16>(data + 6);
  const char* const end = data + header_bytes + read<u64>(data + 8);
  for (const char* entry = data + header_bytes; entry < end;) {
    const auto entry_header_bytes = read<u32>(entry + 4);
    const auto bytes = read<u64>(entry + 8);
    const char* const content = entry + entry_header_bytes;
    if (read<u16>(entry) == kPtx) {
      const std::string_view text(content, strnlen(content, bytes));
      const u32 architecture = architecture_of(text);
      if (architecture <= settings().compute_capability && architecture > module->architecture) {
        module->architecture = architecture;
        module->text = text;
      }
    }
    entry = content + bytes;
  }
  return reinterpret_cast<void**>(module);
}

void register_kernel(void** binary, const void* host, const char* name) {
  kernels()[host] = {reinterpret_cast<Module*>(binary), name};
}

const Function* find_kernel(const void* host) {
  const auto found = kernels().find(host);
  if (found == kernels().end()) return nullptr;
  Module& module = *found->second.module;
  if (module.code.empty()) parse(module);
  const auto function = module.functions.find(found->second.name);
  return function == module.functions.end() || !function->second->is_defined ? nullptr : function->second.get();
}

}  // namespace tetune::ptxsim
