// PETSc's objects as C++ owns them, and its error codes as exceptions.
#pragma once

#include <petscdmda.h>
#include <petscksp.h>

#include <string>
#include <utility>

#include "core/error.h"

namespace kappamu::forward::distributed {

/// Throws where a call of PETSc failed; it has said why by its error handler.
inline void petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error("PETSc: " + std::string(text != nullptr ? text : "unknown error"));
}

/// One reference to an object of PETSc.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Owned {
 public:
  Owned() = default;
  explicit Owned(Object object) : object_(object) {}
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() {
    if (object_ != nullptr) static_cast<void>(destroy(&object_));
  }

  Object get() const { return object_; }
  explicit operator bool() const { return object_ != nullptr; }
  /// For a call that makes the object; destroys the one before.
  Object* receive() {
    *this = Owned();
    return &object_;
  }

 private:
  Object object_ = nullptr;
};

using Grid = Owned<DM, DMDestroy>;
using Vector = Owned<Vec, VecDestroy>;
using Matrix = Owned<Mat, MatDestroy>;
using Solver = Owned<KSP, KSPDestroy>;

/// The values of a vector that lie on this rank.
class Values {
 public:
  explicit Values(Vec vector) : vector_(vector) { petsc(VecGetArray(vector_, &values_)); }
  ~Values() { static_cast<void>(VecRestoreArray(vector_, &values_)); }
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;
  double& operator[](std::size_t i) const { return values_[i]; }

 private:
  Vec vector_;
  double* values_ = nullptr;
};
class ConstValues {
 public:
  explicit ConstValues(Vec vector) : vector_(vector) { petsc(VecGetArrayRead(vector_, &values_)); }
  ~ConstValues() { static_cast<void>(VecRestoreArrayRead(vector_, &values_)); }
  ConstValues(const ConstValues&) = delete;
  ConstValues& operator=(const ConstValues&) = delete;
  const double& operator[](std::size_t i) const { return values_[i]; }

 private:
  Vec vector_;
  const double* values_ = nullptr;
};

}  // namespace kappamu::forward::distributed
