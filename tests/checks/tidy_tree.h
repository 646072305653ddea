// Small rules that keep the tree readable. Each function returns one line for each offence.
#pragma once

#include <string>
#include <vector>

#include "source_tree.h"

namespace checks {

// OpenMP pragmas outside core/base/parallel.cpp: everything else runs loops through parallel_for.
std::vector<std::string> stray_openmp(const SourceTree& tree);
// Code files of one name: a file is known by its name alone. Build files and READMEs are no code.
std::vector<std::string> repeated_names(const SourceTree& tree);
// Files of more than 600 lines.
std::vector<std::string> long_files(const SourceTree& tree);
// Functions of core, capi and packager of more than 60 lines, from the line of the name to the closing brace. Functions
// are told by the tree's layout: their last line is a brace in the first column.
std::vector<std::string> long_functions(const SourceTree& tree);
// Places other than VERSION and the change log where the version is typed.
std::vector<std::string> typed_versions(const SourceTree& tree, const std::string& version);
// Packages that CMake is to find in a version: most say that they fit their own major version alone, so that the next
// release of a system, with the next one, would be refused.
std::vector<std::string> pinned_packages(const SourceTree& tree);
// Files of the runtime with std::ranges: they build for WebAssembly, too, and the C++ library of Debian 12's Emscripten
// has no algorithms of that name.
std::vector<std::string> ranges_in_runtime(const SourceTree& tree);
// Random numbers of core, capi and packager that are of no use of the seed (base/random_streams.h), and uses that are
// named in two places: what is drawn there would be the same.
std::vector<std::string> shared_streams(const SourceTree& tree);

}  // namespace checks
