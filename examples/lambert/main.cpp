// The kappamu command with one more model.
#include "app/command_list.h"
#include "app/program.h"
#include "lambert_model.h"

int main(int argc, char** argv) {
  kappamu::forward::add_object_model(lambert_model());
  return kappamu::app::run_program(argc, argv, kappamu::app::add_commands);
}
