// `kappamu view` where the libraries of the window were not there when kappamu was built.
#include "app/viewer/viewer.h"
#include "core/error.h"

namespace kappamu::app {

ViewerTimes view(const render::Scene&, const LiveMaker&, const ViewerOptions&) {
  throw InputError(
      "kappamu was built without its window; install the Debian packages libglfw3-dev, "
      "libimgui-dev "
      "and libepoxy-dev, then build again");
}

}  // namespace kappamu::app
