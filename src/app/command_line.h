// The program's command line.
#pragma once

namespace maille {

// Reads the words, runs the command, and says on stderr why it could not be done. Returns the exit
// code (core/result.h).
int run_command_line(int argc, const char* const* argv);

}  // namespace maille
