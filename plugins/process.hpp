// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>

#include <functional>
#include <string>
#include <string_view>

#include "io/mesh_stream.hpp"
#include "io/plugin/plugin_protocol.hpp"
#include "plugin.hpp"

/// Shared by the programs of all plugins: the channel to tetune, signals and limits
/// (src/io/plugin/plugin_protocol.hpp).
namespace tetune::plugin {

/// Writes to the channel. Throws FileError.
struct ChannelSink {
  void operator()(const void* data, std::size_t bytes) const;
};
using AnswerWriter = MeshWriter<ChannelSink>;
/// Writes the rest of an answer; may be empty.
using AnswerBody = std::function<void(AnswerWriter&)>;

/// Calls `decode` with a reader of the input behind its version. Throws FileError.
void receive(const std::function<void(MeshReader&)>& decode);

/// Whether this process was started by tetune: with a channel.
bool has_channel();

/// An interrupt from the terminal is for tetune to handle. When tetune ends, this process ends, too, and deletes
/// `written_file` unless it is null.
void install_signal_handlers(const char* written_file);

/// Limits the memory of this process, while it lives, to what a file of its size can fill: libraries trust the counts
/// of a damaged file. The factor allows for compressed files.
class MemoryLimit {
 public:
  explicit MemoryLimit(const std::string& file);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

/// Runs `work`, which may add warnings, and answers with the body that it returns, or with the message of the exception
/// that it throws. Returns the exit code.
int run_and_answer(const std::function<AnswerBody(Warnings&)>& work);

}  // namespace tetune::plugin
