// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The protocol between tetune and the programs of its plugins.
///
///   PROGRAM read FILE [N]  answer: kAnswerVersion, error, warnings, mesh (when error is empty), with the values of the
///                          Nth of its times
///   PROGRAM times FILE     answer: kAnswerVersion, error, no warnings, times
///   PROGRAM check FILE     answer: kAnswerVersion, error, no warnings: whether the library has the format of this name
///   PROGRAM write FILE     input: kStreamVersion, mesh; answer: kAnswerVersion, error, warnings
///
/// The plugin for CAD geometry keeps its file for many requests:
///
///   PROGRAM serve FILE
///
/// A request is a byte on the standard input, a socket, and ends with a byte back. Input: kStreamVersion, verb, query;
/// answer: kAnswerVersion, error, warnings, answer, with the types of geometry_stream.hpp:
///
///   load      no query, LoadedModel; the first request
///   classify  ClassifyQuery, ClassifyAnswer
///   project   ProjectQuery, ProjectAnswer
///
/// Input and answer go through the descriptor kPluginDescriptor, a file in memory, encoded as in mesh_stream.hpp; the
/// answer replaces the input. The exit code is 0 whenever there is an answer. Where tetune, whose process id is the
/// owner of the descriptor (F_GETOWN), ends before the program does, the program ends and deletes the FILE that it
/// writes.
namespace tetune {

inline constexpr int kPluginDescriptor = 3;
/// Exit code of the system's loader when a shared library is missing.
inline constexpr int kPluginNotLoaded = 127;
/// Exit code of a program that is a script of Python where no interpreter can run it.
inline constexpr int kPluginNoInterpreter = 126;

}  // namespace tetune
