#include "app/viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "core/error.h"

namespace kappamu::app {

namespace {

/// The panel answers to what happened in one frame and takes its new size in the next.
constexpr int frames_per_event = 3;

void happened(GLFWwindow* window) {
  *static_cast<int*>(glfwGetWindowUserPointer(window)) = frames_per_event;
}

/// Dear ImGui's own callbacks, installed later, call these too.
void count_events(GLFWwindow* window, int* frames_due) {
  glfwSetWindowUserPointer(window, frames_due);
  glfwSetCursorPosCallback(window, [](GLFWwindow* of, double, double) { happened(of); });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* of, int) { happened(of); });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* of, int, int, int) { happened(of); });
  glfwSetScrollCallback(window, [](GLFWwindow* of, double, double) { happened(of); });
  glfwSetKeyCallback(window, [](GLFWwindow* of, int, int, int, int) { happened(of); });
  glfwSetCharCallback(window, [](GLFWwindow* of, unsigned) { happened(of); });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* of, int) { happened(of); });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* of) { happened(of); });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* of, int, int) { happened(of); });
}

}  // namespace

Window::Window(int width, int height, WindowKind kind) {
  if (glfwInit() != GLFW_TRUE) {
    throw InputError(
        "no window can be opened: there is no display; set DISPLAY, or run `xvfb-run -a kappamu "
        "view`");
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
  count_events(window_, &frames_due_);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

bool Window::wait_for_events(double seconds) {
  if (frames_due_ > 0) {
    glfwPollEvents();
  } else {
    glfwWaitEventsTimeout(seconds);
  }
  if (frames_due_ == 0) return false;
  --frames_due_;
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
