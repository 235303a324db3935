// SPDX-License-Identifier: Apache-2.0
#include <vtkErrorCode.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cerrno>
#include <cstring>

#include "exodus.hpp"
#include "grid.hpp"
#include "limited_names.hpp"
#include "plugin.hpp"

namespace tetune::plugin {
namespace {

/// Keeps the first error that VTK reports, and whether it warns of a file that ends too early.
class Messages : public vtkOutputWindow {
 public:
  static Messages* New() { VTK_STANDARD_NEW_BODY(Messages); }
  void DisplayErrorText(const char* text) override {
    // The name of the filter that failed means nothing to a user.
    if (std::strstr(text, "returned failure for request") != nullptr) {
      damaged_ = true;
    } else if (first_.empty()) {
      first_ = text;
    }
  }
  void DisplayWarningText(const char* text) override {
    if (std::strstr(text, "Error reading") != nullptr) damaged_ = true;
  }
  void DisplayGenericWarningText(const char* text) override { DisplayWarningText(text); }
  void DisplayText(const char*) override {}
  /// Throws FileError where there was an error. VTK's text starts with a place in its source.
  void check() const {
    if (first_.empty() && damaged_) throw FileError("the file is damaged or cut short");
    if (first_.empty()) return;
    std::string text = first_;
    if (const auto at = text.find("): "); at != std::string::npos) text = text.substr(at + 3);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    for (char& c : text) c = c == '\n' ? ' ' : c;
    throw FileError((damaged_ ? "the file is damaged or cut short; VTK says: " : "VTK says: ") + text);
  }

 private:
  std::string first_;
  bool damaged_ = false;
};
template <class Reader>
TetMesh read_xml(const std::string& file, Pieces pieces, const Messages& messages, Warnings& warnings) {
  vtkNew<Reader> reader;
  if (reader->CanReadFile(file.c_str()) == 0) {
    throw FileError("this is not a VTK XML file of an unstructured grid");
  }
  reader->SetFileName(file.c_str());
  reader->Update();
  messages.check();
  return from_grid(reader->GetOutput(), pieces, warnings);
}

TetMesh read_legacy(const std::string& file, const Messages& messages, Warnings& warnings) {
  vtkNew<vtkUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  if (reader->IsFileUnstructuredGrid() == 0) {
    throw FileError("this is not a VTK legacy file of an unstructured grid (DATASET UNSTRUCTURED_GRID)");
  }
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllFieldsOn();
  reader->Update();
  messages.check();
  return from_grid(reader->GetOutput(), Pieces::one, warnings);
}

/// Writes a grid to a file; returns false where the writer failed.
template <class Writer>
bool write_by(Writer& writer) {
  errno = 0;
  const bool written = writer.Write() == 1 && writer.GetErrorCode() == vtkErrorCode::NoError;
  // VTK's own message names another cause.
  if (!written && errno == ENOSPC) throw FileError(std::string("cannot write: ") + std::strerror(ENOSPC));
  return written;
}

}  // namespace

void check(const std::string&) {}

std::vector<double> times(const std::string& file) { return exodus_times(file); }

TetMesh read(const std::string& file, int time, Warnings& warnings) {
  vtkNew<Messages> messages;
  vtkOutputWindow::SetInstance(messages);
  const std::string ending = ending_of(file);
  if (ending == ".vtu") return read_xml<vtkXMLUnstructuredGridReader>(file, Pieces::one, *messages, warnings);
  if (ending == ".pvtu") {
    return read_xml<vtkXMLPUnstructuredGridReader>(file, Pieces::several, *messages, warnings);
  }
  if (ending == ".vtk") return read_legacy(file, *messages, warnings);
  TetMesh mesh = read_exodus(file, time, warnings);
  messages->check();
  return mesh;
}

void write(const std::string& file, TetMesh mesh, Warnings& warnings) {
  vtkNew<Messages> messages;
  vtkOutputWindow::SetInstance(messages);
  const std::string ending = ending_of(file);
  bool written = false;
  if (ending == ".vtu") {
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetFileName(file.c_str());
    writer->SetInputData(to_grid(std::move(mesh), warnings));
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetHeaderTypeToUInt64();
    writer->SetCompressorTypeToZLib();
    writer->SetCompressionLevel(1);
    written = write_by(*writer);
  } else if (ending == ".vtk") {
    shorten_names_for_legacy(mesh, warnings);
    vtkNew<vtkUnstructuredGridWriter> writer;
    writer->SetFileName(file.c_str());
    writer->SetInputData(to_grid(std::move(mesh), warnings));
    writer->SetFileTypeToBinary();
    writer->SetFileVersion(vtkUnstructuredGridWriter::VTK_LEGACY_READER_VERSION_4_2);  // older programs read it too
    written = write_by(*writer);
  } else {
    write_exodus(file, std::move(mesh), warnings);
    written = true;
  }
  messages->check();
  if (!written) throw FileError("VTK could not write it");
}

}  // namespace tetune::plugin
