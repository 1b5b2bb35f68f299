#include "app/viewer/panel/panel_picture.h"

#include <epoxy/gl.h>
#include <imgui.h>

namespace kappamu::app {

void PanelPicture::draw(const std::vector<std::uint8_t>& pixels, int columns, int rows, float width,
                        float height) {
  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, columns, rows, 0, GL_RGB, GL_UNSIGNED_BYTE,
               pixels.data());
  ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture_)),
               {width, height});
}

}  // namespace kappamu::app
