// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "io/mesh_stream.hpp"
#include "io/registry.hpp"

namespace tetune {

using PluginWriter = MeshWriter<std::function<void(const void*, std::size_t)>>;

/// Runs the plugin's program on a file and returns when it has answered: `write` encodes its input, `read` decodes the
/// rest of its answer; either may be empty. Throws FileError, with what to install where the plugin or its library is
/// missing. `path` stands for the file in messages.
void call_plugin(const Plugin& plugin, const char* verb, const std::string& path, const std::string& file,
                 const IoContext& context, const std::function<void(PluginWriter&)>& write,
                 const std::function<void(MeshReader&)>& read);

}  // namespace tetune
