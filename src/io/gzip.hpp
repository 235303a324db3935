// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "system/file.hpp"

/// Compressed files, through zlib. Without it, each of these throws FileError.
namespace tetune {

/// Returns what a .gz file holds; `path` stands for it in messages.
std::string gunzip(const std::string& path, std::string_view bytes);

/// Compresses what is written to a file.
class GzipWriter {
 public:
  explicit GzipWriter(FileWriter& file);
  ~GzipWriter();
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;
  void write(std::string_view text);
  /// Writes the end of the compressed data; nothing may follow.
  void finish();

 private:
  struct Stream;
  FileWriter& file_;
  std::unique_ptr<Stream> stream_;
};

}  // namespace tetune
