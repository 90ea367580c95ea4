#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace steadymap {

/// Adds the option `--set` of a command that builds maps: parameters of their policies, for
/// `ParseParameters`. `parameters` must outlive the command.
void AddParameterOption(CLI::App* command, std::vector<std::string>* parameters);

}  // namespace steadymap
