// A GLFW window with OpenGL 3.3 and Dear ImGui, closed with its owner.
#pragma once

#include <string>
#include <vector>

struct GLFWwindow;

namespace kappamu::app {

enum class WindowKind { shown, hidden };

/// The left button and the pointer [screen coordinates from the window's top left corner], as they
/// were at one moment.
struct PointerEvent {
  double x = 0.0, y = 0.0;
  bool left = false;     ///< held
  bool pressed = false;  ///< at this moment
};

/// A key that was pressed, as GLFW names it.
struct KeyEvent {
  int key = 0;
  bool control = false, shift = false;
};

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
  /// The picture changes by itself: it is drawn as after an event.
  void draw_again() { events_.frames_due = frames_per_event; }
  /// Everything since the last call, in order: several positions may lie between two frames.
  std::vector<PointerEvent> take_pointer_events();
  std::vector<KeyEvent> take_key_events();
  /// As if the pointer had been there.
  void point(const PointerEvent& event) { events_.pointer.push_back(event); }
  /// Files that were dropped on the window since the last call.
  std::vector<std::string> take_dropped();
  /// Of text and marks: 2 on a screen of twice the usual density.
  float scale() const { return scale_; }

 private:
  /// The panel answers to what happened in one frame and takes its new size in the next.
  static constexpr int frames_per_event = 3;
  struct Events {
    int frames_due = frames_per_event;
    std::vector<PointerEvent> pointer;
    PointerEvent last;
    std::vector<KeyEvent> keys;
    std::vector<std::string> dropped;
  };
  static void count_events(GLFWwindow* window, Events& events);

  GLFWwindow* window_ = nullptr;
  Events events_;
  float scale_ = 1.0F;
};

}  // namespace kappamu::app
