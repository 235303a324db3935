// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "io/mesh_stream.hpp"
#include "io/registry.hpp"
#include "system/child_process.hpp"

namespace tetune {

using PluginWriter = MeshWriter<std::function<void(const void*, std::size_t)>>;

/// A plugin's program that keeps a file for many requests, which end it only where they crash it. May be called from
/// several threads, which wait for each other.
class PluginSession {
 public:
  PluginSession(const Plugin& plugin, std::string file) : plugin_(plugin), file_(std::move(file)) {}
  /// Returns when the program has answered: `write` encodes its input, `read` decodes the rest of its answer; either
  /// may be empty. The first request starts the program. Throws FileError, with what to install where the plugin or its
  /// library is missing.
  void call(const char* verb, const IoContext& context, const std::function<void(PluginWriter&)>& write,
            const std::function<void(MeshReader&)>& read);

 private:
  const Plugin& plugin_;
  const std::string file_;
  std::mutex mutex_;
  std::unique_ptr<MemoryFile> channel_;
  std::unique_ptr<ChildProcess> process_;
};

}  // namespace tetune
