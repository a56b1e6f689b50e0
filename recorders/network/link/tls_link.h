// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "recorders/network/link/byte_link.h"

namespace trilat {

// The name that the recording machine's certificate bears, in every set of keys.
inline constexpr const char* kTlsServerName = "trilat-recorder";

// Private key, certificate and authority of one machine, read from one PEM file as made by make_tls_keys().
// Immutable: any number of links and threads may share one.
class TlsIdentity {
 public:
  // InputError naming the file where it cannot be read, others may read it, or a part is missing.
  explicit TlsIdentity(const std::filesystem::path& pem);
  ~TlsIdentity();
  TlsIdentity(const TlsIdentity&) = delete;
  TlsIdentity& operator=(const TlsIdentity&) = delete;

  const std::string& name() const { return name_; }

  struct Keys;
  const Keys& keys() const { return *keys_; }

 private:
  std::unique_ptr<Keys> keys_;
  std::string name_;
};

enum class TlsSide { agent, server };

// TLS 1.3 over `inner`; both sides prove that the same authority knows them, an agent moreover that it speaks
// with the recording machine. Blocks until the handshake is done: LinkLost where it is not in time or
// `give_up` says so, LinkRefused where a proof fails.
std::unique_ptr<ByteLink> secure_link(
    std::unique_ptr<ByteLink> inner, const TlsIdentity& identity, TlsSide side,
    std::chrono::milliseconds at_most, const std::function<bool()>& give_up = [] { return false; });

}  // namespace trilat
