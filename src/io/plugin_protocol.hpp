// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The protocol between tetune and the programs of its plugins.
///
///   PROGRAM read FILE      answer: kAnswerVersion, error, warnings, mesh (when error is empty)
///   PROGRAM check FILE     answer: kAnswerVersion, error, no warnings: whether the library has the format of this name
///   PROGRAM write FILE     input: kStreamVersion, mesh; answer: kAnswerVersion, error, warnings
///
/// and of the plugin for CAD geometry, with the types of geometry_stream.hpp:
///
///   PROGRAM load FILE      answer: kAnswerVersion, error, warnings, LoadedModel
///   PROGRAM classify FILE  input: kStreamVersion, ClassifyQuery; answer: kAnswerVersion, error, none, ClassifyAnswer
///   PROGRAM project FILE   input: kStreamVersion, ProjectQuery; answer: kAnswerVersion, error, none, ProjectAnswer
///
/// Input and answer go through the descriptor kPluginDescriptor, a file in memory, encoded as in mesh_stream.hpp; the
/// answer replaces the input. The exit code is 0 whenever there is an answer. Where tetune ends before the program
/// does, the program deletes the FILE that it writes.
namespace tetune {

inline constexpr int kPluginDescriptor = 3;
/// Exit code of the system's loader when a shared library is missing.
inline constexpr int kPluginNotLoaded = 127;

}  // namespace tetune
