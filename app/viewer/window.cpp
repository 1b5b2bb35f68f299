#include "app/viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::app {

namespace {

constexpr float usual_text_px = 13.0F;

}  // namespace

/// Dear ImGui's own callbacks, installed later, call these too.
void Window::count_events(GLFWwindow* window, Events& events) {
  static constexpr auto of = [](GLFWwindow* which) -> Events& {
    return *static_cast<Events*>(glfwGetWindowUserPointer(which));
  };
  static constexpr auto happened = [](GLFWwindow* which) {
    of(which).frames_due = frames_per_event;
  };
  // As the events have it: glfwGetCursorPos() is already further on.
  static constexpr auto pointer = [](GLFWwindow* which) {
    happened(which);
    of(which).pointer.push_back(of(which).last);
    of(which).last.pressed = false;
  };
  glfwSetWindowUserPointer(window, &events);
  glfwSetCursorPosCallback(window, [](GLFWwindow* in, double x, double y) {
    of(in).last.x = x;
    of(in).last.y = y;
    pointer(in);
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* in, int button, int action, int) {
    if (button == GLFW_MOUSE_BUTTON_LEFT) {
      of(in).last.left = of(in).last.pressed = action == GLFW_PRESS;
    }
    pointer(in);
  });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* in, int) { happened(in); });
  glfwSetScrollCallback(window, [](GLFWwindow* in, double, double) { happened(in); });
  glfwSetKeyCallback(window, [](GLFWwindow* in, int key, int, int action, int mods) {
    happened(in);
    if (action == GLFW_RELEASE) return;
    of(in).keys.push_back({key, (mods & GLFW_MOD_CONTROL) != 0, (mods & GLFW_MOD_SHIFT) != 0});
  });
  glfwSetDropCallback(window, [](GLFWwindow* in, int count, const char** paths) {
    happened(in);
    of(in).dropped.insert(of(in).dropped.end(), paths, paths + count);
  });
  glfwSetCharCallback(window, [](GLFWwindow* in, unsigned) { happened(in); });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* in, int) { happened(in); });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* in) { happened(in); });
  glfwSetWindowCloseCallback(window, [](GLFWwindow* in) { happened(in); });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* in, int, int) { happened(in); });
}

std::vector<PointerEvent> Window::take_pointer_events() {
  return std::exchange(events_.pointer, {});
}

std::vector<KeyEvent> Window::take_key_events() {
  return std::exchange(events_.keys, {});
}

std::vector<std::string> Window::take_dropped() {
  return std::exchange(events_.dropped, {});
}

Window::Window(int width, int height, WindowKind kind) {
  if (glfwInit() != GLFW_TRUE) {
    throw InputError(
        "no window can be opened: there is no display; set DISPLAY, or run `xvfb-run -a kappamu "
        "view`");
  }
  if (GLFWmonitor* screen = glfwGetPrimaryMonitor(); screen && kind == WindowKind::shown) {
    int left = 0, top = 0, across = width, high = height;
    glfwGetMonitorWorkarea(screen, &left, &top, &across, &high);
    if (across > 0) width = std::min(width, across);
    if (high > 0) height = std::min(height, high);
  }
  constexpr int largest = 32767;  // of X11's windows, which end the program beyond
  if (std::max(width, height) > largest) {
    glfwTerminate();
    throw InputError(formatted(
        "displays hold at most %d px a side, not a picture of %d x %d px; take a smaller width",
        largest, width, height));
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, kind == WindowKind::shown ? GLFW_TRUE : GLFW_FALSE);
  window_ = glfwCreateWindow(width, height, "kappamu", nullptr, nullptr);
  if (window_ == nullptr) {
    glfwTerminate();
    throw InputError("no window can be opened: this display has no OpenGL 3.3; install its driver");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(kind == WindowKind::shown ? 1 : 0);
  count_events(window_, events_);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  if (kind == WindowKind::shown) glfwGetWindowContentScale(window_, &scale_, nullptr);
  ImFontConfig font;
  font.SizePixels = std::round(usual_text_px * scale_);
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::GetStyle().ScaleAllSizes(scale_);
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

bool Window::wait_for_events(double seconds) {
  if (events_.frames_due > 0) {
    glfwPollEvents();
  } else {
    glfwWaitEventsTimeout(seconds);
  }
  if (events_.frames_due == 0) return false;
  --events_.frames_due;
  return true;
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

}  // namespace kappamu::app
