// A GLFW window with OpenGL 3.3 and Dear ImGui, closed with its owner.
#pragma once

struct GLFWwindow;

namespace kappamu::app {

enum class WindowKind { shown, hidden };

class Window {
 public:
  /// Throws InputError where there is no display or no OpenGL 3.3.
  Window(int width, int height, WindowKind kind);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  GLFWwindow* handle() const { return window_; }

  /// Waits for what a person does, no longer than this. Whether the picture may have to be drawn
  /// again for it.
  bool wait_for_events(double seconds);

 private:
  GLFWwindow* window_ = nullptr;
  int frames_due_ = 1;
};

}  // namespace kappamu::app
