#include <iostream>
#include <string>
#include <vector>

#include <unistd.h>

#include "client/cli/command_line.h"
#include "client/transport/channel.h"

int main(int argc, char** argv) {
  steadymap::CommandContext context{.out = std::cout, .err = std::cerr};
  context.err_is_terminal = isatty(STDERR_FILENO) == 1;
  context.open_channel = steadymap::OpenChannel;
  return steadymap::RunCommandLine(std::vector<std::string>(argv + 1, argv + argc), &context);
}
