// The kappamu command.
#include "app/command_list.h"
#include "app/program.h"

int main(int argc, char** argv) {
  return kappamu::app::run_program(argc, argv, kappamu::app::add_commands);
}
