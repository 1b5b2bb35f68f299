#include "io/json_node.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::io {

using nlohmann::json;

namespace {

using Words = std::vector<std::string_view>;

bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string list(const Words& words, const std::string& separator) {
  std::string text;
  for (const std::string_view word : words) {
    text += (text.empty() ? "'" : separator + "'") + std::string(word) + "'";
  }
  return text;
}

// What the library's own document does not tell: of two equal keys it keeps the last, and it copies
// and writes by recursion, as deep as a stranger likes. A pass of its own: the library's parser
// with a callback takes quadratic time over an array of objects.
class Structure final : public nlohmann::json_sax<json> {
 public:
  std::string fault;  // of the first; reading stops there

  bool null() override { return true; }
  bool boolean(bool /*value*/) override { return true; }
  bool number_integer(number_integer_t /*value*/) override { return true; }
  bool number_unsigned(number_unsigned_t /*value*/) override { return true; }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return true; }
  bool string(string_t& /*value*/) override { return true; }
  bool binary(binary_t& /*value*/) override { return true; }
  bool start_object(std::size_t /*size*/) override {
    open_objects_.emplace_back();
    return enter();
  }
  bool key(string_t& key) override {
    if (open_objects_.back().insert(key).second) return true;
    fault = "field '" + shown_name(key) + "' occurs twice in one object; remove one of the two";
    return false;
  }
  bool end_object() override {
    open_objects_.pop_back();
    --depth_;
    return true;
  }
  bool start_array(std::size_t /*size*/) override { return enter(); }
  bool end_array() override {
    --depth_;
    return true;
  }
  // The document's own parser says what and where.
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/,
                   const json::exception& /*error*/) override {
    return false;
  }

 private:
  bool enter() {
    if (++depth_ <= most_depth) return true;
    fault = "its lists and objects are nested more than " + std::to_string(most_depth) +
            " deep; correct it there";
    return false;
  }

  static constexpr int most_depth = 100;
  int depth_ = 0;
  std::vector<std::set<std::string>> open_objects_;
};

json parse(const std::string& text, const std::string& file) {
  Structure structure;
  json::sax_parse(text, &structure);
  if (!structure.fault.empty()) throw InputError(file + ": " + structure.fault + ".");
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    throw InputError(file + ": not valid JSON (" + shown_text(json_reason(error)) +
                     "); correct it there.");
  }
}

// Strings that are not UTF-8 cannot be quoted.
std::string quoted(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

void JsonNode::fail(const std::string& what) const {
  throw InputError(document_->file_ + ": " + (path_.empty() ? "the document" : path_) + " " + what +
                   ".");
}

void JsonNode::expect_fields(const Words& required, const Words& optional) const {
  Words allowed = required;
  allowed.insert(allowed.end(), optional.begin(), optional.end());
  if (!value_->is_object()) fail("is " + kind() + "; write an object in braces");
  for (const auto& [name, unused] : value_->items()) {
    if (document_->comments_ == JsonComments::allowed && name == "_comment") continue;
    if (!contains(allowed, name)) {
      JsonNode(*value_, child_path(name), *document_)
          .fail("is an unknown field; allowed here are " + list(allowed, ", "));
    }
  }
  for (const std::string_view name : required) {
    if (!has(name)) {
      JsonNode(*value_, child_path(name), *document_)
          .fail("is missing; add it (" + document_->hint_ + ")");
    }
  }
}

void JsonNode::expect_format(const char* name) const {
  (*this)["format"].choice({name});
  const JsonNode version = (*this)["version"];
  if (version.number() != 1.0) version.fail("is not 1; this program reads version 1");
}

bool JsonNode::has(std::string_view name) const {
  return value_->contains(name);
}

JsonNode JsonNode::operator[](const char* name) const {
  return {value_->at(name), child_path(name), *document_};
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members() const {
  if (!value_->is_object()) fail("is " + kind() + "; write an object in braces");
  std::vector<std::pair<std::string, JsonNode>> nodes;
  for (const auto& [name, value] : value_->items()) {
    nodes.emplace_back(name, JsonNode(value, child_path(name), *document_));
  }
  return nodes;
}

std::vector<JsonNode> JsonNode::items(std::size_t at_least) const {
  if (!value_->is_array()) fail("is " + kind() + "; write a list in brackets");
  if (value_->size() < at_least) {
    fail("has " + std::to_string(value_->size()) + " entries; it needs at least " +
         std::to_string(at_least));
  }
  std::vector<JsonNode> nodes;
  nodes.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    nodes.push_back(JsonNode((*value_)[i], path_ + "[" + std::to_string(i) + "]", *document_));
  }
  return nodes;
}

std::vector<JsonNode> JsonNode::exactly(std::size_t count) const {
  std::vector<JsonNode> nodes = items(0);
  if (nodes.size() != count) {
    fail("has " + std::to_string(nodes.size()) + " entries; it needs exactly " +
         std::to_string(count));
  }
  return nodes;
}

bool JsonNode::is_number() const {
  return value_->is_number();
}

std::string JsonNode::text() const {
  if (!value_->is_string()) fail("is " + kind() + "; write a text in quotes");
  return value_->get<std::string>();
}

bool JsonNode::flag() const {
  if (!value_->is_boolean()) fail("is " + kind() + "; write true or false");
  return value_->get<bool>();
}

double JsonNode::number() const {
  if (!value_->is_number()) fail("is " + kind() + "; write a number");
  return value_->get<double>();
}

double JsonNode::number_between(double smallest, double largest) const {
  const double value = number();
  if (!(value >= smallest && value <= largest)) {
    fail("is " + quoted(*value_) + "; write a number from " + quoted(json(smallest)) + " to " +
         quoted(json(largest)));
  }
  return value;
}

int JsonNode::integer() const {
  const double value = number();
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    fail("is " + quoted(*value_) + "; write a whole number");
  }
  return static_cast<int>(value);
}

std::uint64_t JsonNode::whole() const {
  if (!value_->is_number_unsigned()) {
    fail("is " + kind() + "; write a whole number that is not negative");
  }
  return value_->get<std::uint64_t>();
}

std::string JsonNode::choice(const Words& choices) const {
  std::string value = text();
  if (!contains(choices, value))
    fail("is '" + shown_name(value) + "'; write " + list(choices, " or "));
  return value;
}

std::string JsonNode::one_of(const std::vector<std::string>& choices) const {
  std::string value = text();
  if (std::find(choices.begin(), choices.end(), value) == choices.end()) {
    std::string listed;
    for (const std::string& one : choices) listed += (listed.empty() ? "" : ", ") + one;
    fail("is '" + shown_name(value) + "'; write one of " + listed);
  }
  return value;
}

std::array<int, 3> JsonNode::grid() const {
  std::array<int, 3> extents{};
  const std::vector<JsonNode> nodes = exactly(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes[axis].number_between(1, 65536);
    extents[axis] = nodes[axis].integer();
  }
  return extents;
}

std::vector<std::string> JsonNode::names() const {
  std::vector<std::string> result;
  for (const JsonNode& node : items(1)) {
    const std::string name = node.text();
    require_plain_name(name, document_->file_ + ": " + node.path_);
    if (std::find(result.begin(), result.end(), name) != result.end()) {
      fail("names '" + name + "' twice; keep one");
    }
    result.push_back(name);
  }
  return result;
}

std::string JsonNode::child_path(std::string_view name) const {
  return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
}

std::string JsonNode::kind() const {
  if (value_->is_object()) return "an object";
  if (value_->is_array()) return "a list";
  if (value_->is_string()) return "a text";
  return quoted(*value_);
}

JsonDocument::JsonDocument(const std::filesystem::path& file, std::string hint,
                           JsonComments comments)
    : JsonDocument(file.string(), read_text(file), std::move(hint), comments) {}

JsonDocument::JsonDocument(std::string name, const std::string& text, std::string hint,
                           JsonComments comments)
    : file_(std::move(name)),
      hint_(std::move(hint)),
      comments_(comments),
      json_(std::make_unique<json>(parse(text, file_))) {}

JsonDocument JsonDocument::of_text(const std::string& text, std::string name, std::string hint,
                                   JsonComments comments) {
  return {std::move(name), text, std::move(hint), comments};
}

JsonDocument::~JsonDocument() = default;

JsonNode JsonDocument::root() const {
  return {*json_, "", *this};
}

}  // namespace kappamu::io
