// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "tetune/export.hpp"

/// Files: reading by memory mapping, and writing such that a file is replaced as a whole or not at all.
namespace tetune {

/// A whole file or descriptor mapped into memory, read-only. Throws FileError.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path);
  /// Maps what an open descriptor refers to; `name` stands for it in messages. The descriptor stays open.
  MappedFile(int descriptor, const std::string& name) { map(descriptor, name); }
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view bytes() const { return bytes_; }

 private:
  void map(int descriptor, const std::string& name);
  std::string_view bytes_;
};

/// The name of a temporary file in the folder of `path`, with the same extension, because some libraries choose the
/// format by it. The destructor deletes the file, unless replace() has moved it to `path`.
class TETUNE_API TemporaryFile {
 public:
  explicit TemporaryFile(std::string path);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& name() const { return name_; }
  /// Renames the file to `path`; a file that it replaces hands its permissions on. Throws FileError.
  void replace();

 private:
  std::string path_, name_;
};

/// Writes a file that appears under its name as a whole when commit() is called; an old file is untouched before. Until
/// then the file has no name (O_TMPFILE), so that a process that ends early leaves nothing behind. Where the file
/// system lacks such files it is a TemporaryFile, which a signal may leave. Throws FileError.
class FileWriter {
 public:
  explicit FileWriter(std::string path);
  /// Writes to an open descriptor, which stays open; commit() does nothing. `name` stands for it in messages.
  FileWriter(int descriptor, std::string name)
      : path_(std::move(name)), descriptor_(descriptor), owns_descriptor_(false) {}
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();

 private:
  std::string path_;
  int descriptor_ = -1;
  bool owns_descriptor_ = true;
  std::optional<TemporaryFile> temporary_;  ///< empty as long as the file has no name
};

}  // namespace tetune
