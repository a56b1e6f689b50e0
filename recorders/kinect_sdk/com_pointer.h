// SPDX-License-Identifier: MIT
#pragma once

#include <utility>

namespace trilat::kinect {

// Owns one reference to a COM object.
template <class Interface>
class ComPointer {
 public:
  ComPointer() = default;
  ~ComPointer() { reset(); }
  ComPointer(const ComPointer&) = delete;
  ComPointer& operator=(const ComPointer&) = delete;

  // For a function that hands a reference over.
  Interface** put() {
    reset();
    return &object_;
  }
  void reset() {
    if (Interface* object = std::exchange(object_, nullptr)) object->Release();
  }
  Interface* operator->() const { return object_; }
  Interface& operator*() const { return *object_; }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  Interface* object_ = nullptr;
};

}  // namespace trilat::kinect
