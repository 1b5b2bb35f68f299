// A small writer of HTML and SVG. Markup has its own type, so that plain text can only enter a page
// escaped.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kappamu::report {

/// A piece of finished markup.
class Html {
 public:
  Html() = default;
  const std::string& markup() const { return markup_; }
  bool empty() const { return markup_.empty(); }
  Html& operator+=(const Html& other) {
    markup_ += other.markup_;
    return *this;
  }
  friend Html operator+(Html left, const Html& right) {
    left += right;
    return left;
  }

 private:
  friend Html raw(std::string markup);
  std::string markup_;
};

using Attributes = std::vector<std::pair<std::string_view, std::string>>;

/// Markup taken as it is: style sheets and entities of our own.
Html raw(std::string markup);
/// Plain text, escaped.
Html text(std::string_view plain);
/// <tag attributes>content</tag>
Html element(std::string_view tag, const Attributes& attributes, const Html& content);
inline Html element(std::string_view tag, const Html& content) {
  return element(tag, {}, content);
}
/// <tag attributes>, for elements without content: img, br, SVG shapes.
Html empty_element(std::string_view tag, const Attributes& attributes);

Html paragraph(std::string_view plain);
/// A muted sentence: captions, and the note that says what a run folder lacks.
Html note(std::string_view plain);
/// What links to a section are made of: "#" and this.
std::string anchor(std::string_view title);
/// One section of the page under a heading.
Html section(std::string_view title, const Html& content);
/// Content under a smaller heading.
Html subsection(std::string_view title, const Html& content);
/// Table with a header row (none where `header` is empty); the first column is left-aligned, the
/// others are figures.
Html table(const std::vector<std::string>& header, const std::vector<std::vector<Html>>& rows);
/// Blocks side by side, wrapping where the page ends.
Html row(const std::vector<Html>& blocks);

/// A number with `digits` significant digits: "0.0123", "1.2e-05".
std::string number(double value, int digits = 3);
/// A fraction in per cent: "99.8 %".
std::string percent(double fraction, int digits = 3);
/// "0.8 s", "3 min 20 s".
std::string duration(double seconds);
/// A file size as people read it: "1.3 MB".
std::string file_size(double bytes);

}  // namespace kappamu::report
