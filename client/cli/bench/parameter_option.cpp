#include "client/cli/bench/parameter_option.h"

#include <CLI/CLI.hpp>

namespace steadymap {

void AddParameterOption(CLI::App* command, std::vector<std::string>* parameters) {
  command
      ->add_option("--set",
                   *parameters,
                   "Parameters of the policies, each for those that have it; map create --help "
                   "lists them")
      ->type_name("NAME=VALUE");
}

}  // namespace steadymap
