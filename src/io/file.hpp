// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace tetune {

/// A whole file mapped into memory, read only. Throws FileError.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view bytes() const { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes a file under a temporary name beside its final one; commit() renames it. Without commit() nothing of it
/// stays. Or writes to a descriptor that is open, and stays open. Throws FileError.
class FileWriter {
 public:
  /// `ending` is that of the temporary name, for libraries that go by it.
  explicit FileWriter(std::string path, const std::string& ending = "");
  FileWriter(int descriptor, std::string name) : path_(std::move(name)), descriptor_(descriptor) {}
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();
  /// The temporary name.
  const std::string& temporary() const { return temporary_; }

 private:
  [[noreturn]] void fail(const char* what) const;
  std::string path_;
  std::string temporary_;  ///< empty: not a file of ours
  int descriptor_ = -1;
};

}  // namespace tetune
