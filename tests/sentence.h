// What every module's bad-input tests ask: which sentence did the user get?
#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

#include "core/error.h"

namespace kappamu {

/// The sentence of the InputError that `act` throws; fails the test when it throws none or when
/// the text has several lines.
template <class Act>
std::string sentence_of(const Act& act) {
  try {
    act();
  } catch (const InputError& error) {
    std::string sentence = error.what();
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    return sentence;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "expected InputError, got " << error.what();
    return "";
  }
  ADD_FAILURE() << "expected InputError, nothing was thrown";
  return "";
}

}  // namespace kappamu
