// What every module's bad-input tests ask: which sentence did the user get?
#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <optional>
#include <string>

#include "core/error.h"

namespace kappamu {

/// The sentence of the InputError that `act` throws, with the keys of its options; fails the test
/// when the text has several lines or, unless `accepted` is what to return then, when it throws
/// none.
template <class Act>
std::string sentence_of(const Act& act, const std::optional<std::string>& accepted = {}) {
  try {
    act();
  } catch (const InputError& error) {
    std::string sentence = error.what();
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    std::string options;
    for (const auto& [key, value] : error.options())
      options += (options.empty() ? "" : ", ") + key + (value.empty() ? "" : " " + value);
    return sentence + (options.empty() ? "" : " (" + options + ")");
  } catch (const std::exception& error) {
    ADD_FAILURE() << "expected InputError, got " << error.what();
    return "";
  }
  if (!accepted) ADD_FAILURE() << "expected InputError, nothing was thrown";
  return accepted.value_or("");
}

}  // namespace kappamu
