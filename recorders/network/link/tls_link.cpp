// SPDX-License-Identifier: MIT
#include "recorders/network/link/tls_link.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include <openssl/err.h>
#include <openssl/ssl.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTlsLookPeriod{100};
constexpr std::size_t kBlockBytes = 32u << 10;
constexpr int kBlocksATurn = 16;  // that may hold nothing for us; a record of TLS is shorter
constexpr std::size_t kMaxUnsentBytes = 128u << 10;

template <auto release>
struct OpensslRelease {
  void operator()(auto* handle) const { release(handle); }
};

const TlsKeys& keys_of(const SSL* tls) {
  return *static_cast<const TlsKeys*>(SSL_CTX_get_app_data(SSL_get_SSL_CTX(tls)));
}

// The key of an agent and its name, which the recording machine looks up.
unsigned own_key(SSL* tls, const char*, char* name, unsigned most_name, unsigned char* key,
                 unsigned most_key) {
  const auto& [own_name, own] = *keys_of(tls).begin();
  if (own_name.size() >= most_name || own.size() > most_key) return 0;
  std::memcpy(name, own_name.c_str(), own_name.size() + 1);
  std::copy(own.begin(), own.end(), key);
  return static_cast<unsigned>(own.size());
}

// 0: nobody of this name. Whose key it is stays with the connection, which comes about only with that key.
unsigned key_of_agent(SSL* tls, const char* name, unsigned char* key, unsigned most_key) {
  const auto found = keys_of(tls).find(name);
  if (found == keys_of(tls).end() || found->second.size() > most_key) return 0;
  SSL_set_app_data(tls, const_cast<std::string*>(&found->first));
  std::copy(found->second.begin(), found->second.end(), key);
  return static_cast<unsigned>(found->second.size());
}

// Without certificates there is no handshake but by a shared key.
SSL_CTX* context_for(TlsSide side, const TlsKeys& keys) {
  SSL_CTX* context = SSL_CTX_new(side == TlsSide::server ? TLS_server_method() : TLS_client_method());
  TRILAT_CHECK(context && SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) == 1 &&
                   SSL_CTX_set_ciphersuites(context, "TLS_AES_128_GCM_SHA256") == 1,
               "OpenSSL makes a context");
  SSL_CTX_set_app_data(context, const_cast<TlsKeys*>(&keys));
  SSL_CTX_set_verify(context, side == TlsSide::server ? SSL_VERIFY_NONE : SSL_VERIFY_PEER, nullptr);
  if (side == TlsSide::server)
    SSL_CTX_set_psk_server_callback(context, key_of_agent);
  else
    SSL_CTX_set_psk_client_callback(context, own_key);
  SSL_CTX_set_options(context, SSL_OP_IGNORE_UNEXPECTED_EOF);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_num_tickets(context, 0);
  return context;
}

// The TLS machine works on memory; what it wants sent or has to be given goes through the inner link.
class TlsLink : public ByteLink {
 public:
  TlsLink(std::unique_ptr<ByteLink> inner, const TlsKeys& keys, TlsSide side)
      : inner_(std::move(inner)),
        keys_(keys),
        context_(context_for(side, keys_)),
        tls_(SSL_new(context_.get())),
        block_(kBlockBytes) {
    in_ = BIO_new(BIO_s_mem());
    out_ = BIO_new(BIO_s_mem());
    TRILAT_CHECK(tls_ && in_ && out_, "OpenSSL makes a connection");
    BIO_set_mem_eof_return(in_, -1);
    SSL_set_bio(tls_.get(), in_, out_);
    if (side == TlsSide::server)
      SSL_set_accept_state(tls_.get());
    else
      SSL_set_connect_state(tls_.get());
  }
  ~TlsLink() override {
    try {
      ERR_clear_error();
      if (SSL_is_init_finished(tls_.get())) SSL_shutdown(tls_.get());
      flush();
    } catch (const LinkLost&) {
    }
  }

  void handshake(std::chrono::milliseconds at_most, const std::function<bool()>& give_up) {
    const auto deadline = Clock::now() + at_most;
    for (;;) {
      ERR_clear_error();
      const int result = SSL_do_handshake(tls_.get());
      flush();
      if (result == 1) return;
      must_want_bytes(result);
      if (take_bytes()) continue;
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
      if (left.count() <= 0 || give_up()) throw LinkLost("the handshake was not done in time");
      inner_->wait(unsent(), std::min(left, kTlsLookPeriod));
    }
  }

  std::size_t try_read(std::span<std::byte> into) override {
    for (int i = 0; i < kBlocksATurn; ++i) {
      ERR_clear_error();
      std::size_t count = 0;
      const int result = SSL_read_ex(tls_.get(), into.data(), into.size(), &count);
      flush();
      if (result == 1) return count;
      must_want_bytes(result);
      if (!take_bytes()) return 0;
    }
    return 0;
  }
  std::size_t try_write(std::span<const std::byte> from) override {
    flush();
    if (BIO_ctrl_pending(out_) > kMaxUnsentBytes) return 0;
    ERR_clear_error();
    std::size_t count = 0;
    const int result = SSL_write_ex(tls_.get(), from.data(), from.size(), &count);
    if (result != 1) must_want_bytes(result);
    flush();
    return count;
  }
  void wait(bool to_write, std::chrono::milliseconds at_most) override {
    flush();
    inner_->wait(to_write || unsent(), at_most);
  }
  void wake() override { inner_->wake(); }
  std::string peer_name() const override {
    const auto* name = static_cast<const std::string*>(SSL_get_app_data(tls_.get()));
    return name ? *name : std::string();
  }

 private:
  bool unsent() const { return unsent_start_ < unsent_.size() || BIO_ctrl_pending(out_) > 0; }

  void flush() {
    for (;;) {
      if (unsent_start_ == unsent_.size()) {
        unsent_.resize(std::min(BIO_ctrl_pending(out_), kBlockBytes));
        unsent_start_ = 0;
        if (unsent_.empty()) return;
        const int taken = BIO_read(out_, unsent_.data(), static_cast<int>(unsent_.size()));
        unsent_.resize(static_cast<std::size_t>(std::max(taken, 0)));
      }
      const std::size_t sent = inner_->try_write(std::span<const std::byte>(unsent_).subspan(unsent_start_));
      if (sent == 0) return;
      unsent_start_ += sent;
    }
  }

  bool take_bytes() {
    const std::size_t count = inner_->try_read(block_);
    if (count > 0) BIO_write(in_, block_.data(), static_cast<int>(count));
    return count > 0;
  }

  void must_want_bytes(int result) {
    const int kind = SSL_get_error(tls_.get(), result);
    if (kind == SSL_ERROR_WANT_READ || kind == SSL_ERROR_WANT_WRITE) return;
    if (kind == SSL_ERROR_ZERO_RETURN) throw LinkLost("closed by the other side");
    const unsigned long code = ERR_peek_last_error();
    const char* text = code ? ERR_reason_error_string(code) : nullptr;
    throw LinkRefused(std::string("TLS: ") + (text ? text : "failed"));
  }

  std::unique_ptr<ByteLink> inner_;
  const TlsKeys keys_;
  std::unique_ptr<SSL_CTX, OpensslRelease<SSL_CTX_free>> context_;
  std::unique_ptr<SSL, OpensslRelease<SSL_free>> tls_;
  BIO* in_ = nullptr;  // both belong to tls_
  BIO* out_ = nullptr;
  std::vector<std::byte> block_, unsent_;
  std::size_t unsent_start_ = 0;
};

}  // namespace

std::unique_ptr<ByteLink> secure_link(std::unique_ptr<ByteLink> inner, const TlsKeys& keys, TlsSide side,
                                      std::chrono::milliseconds at_most,
                                      const std::function<bool()>& give_up) {
  TRILAT_CHECK(!keys.empty(), "a secured link has a key");
  auto link = std::make_unique<TlsLink>(std::move(inner), keys, side);
  link->handshake(at_most, give_up);
  return link;
}

}  // namespace trilat
