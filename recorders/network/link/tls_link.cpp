// SPDX-License-Identifier: MIT
#include "recorders/network/link/tls_link.h"

#include <algorithm>
#include <vector>

#include <sys/stat.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "recorders/network/link/openssl_handles.h"

namespace trilat {

struct TlsIdentity::Keys {
  TlsContextHandle as_agent, as_server;
};

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTlsLookPeriod{100};
constexpr std::size_t kBlockBytes = 32u << 10;
constexpr int kBlocksATurn = 16;  // that may hold nothing for us; a record of TLS is shorter
constexpr std::size_t kMaxUnsentBytes = 128u << 10;
constexpr std::size_t kMaxPemBytes = 64u << 10;

struct PemParts {
  KeyHandle key;
  CertificateHandle own, authority;
};

PemParts read_parts(const std::filesystem::path& pem) {
  struct stat status {};
  if (::stat(pem.c_str(), &status) == 0 && (status.st_mode & 077) != 0)
    throw InputError(pem.string(), "holds a private key that others may read; chmod 600 is right");
  const std::string text = read_file(pem, kMaxPemBytes);
  const BioHandle bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
  PemParts parts;
  parts.key.reset(PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, const_cast<char*>("")));
  parts.own.reset(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  parts.authority.reset(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (!parts.key || !parts.own || !parts.authority)
    throw InputError(
        pem.string(),
        "must hold a private key, its certificate and the authority's, as `trilat-agent keys` makes");
  return parts;
}

TlsContextHandle context_of(const PemParts& parts, const SSL_METHOD* method, const std::string& place) {
  TlsContextHandle context(SSL_CTX_new(method));
  TRILAT_CHECK(context, "OpenSSL makes a context");
  const bool taken = SSL_CTX_set_min_proto_version(context.get(), TLS1_3_VERSION) == 1 &&
                     SSL_CTX_use_certificate(context.get(), parts.own.get()) == 1 &&
                     SSL_CTX_use_PrivateKey(context.get(), parts.key.get()) == 1 &&
                     SSL_CTX_check_private_key(context.get()) == 1 &&
                     X509_STORE_add_cert(SSL_CTX_get_cert_store(context.get()), parts.authority.get()) == 1;
  ERR_clear_error();
  if (!taken) throw InputError(place, "has a key and certificates that do not belong together");
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  SSL_CTX_set_options(context.get(), SSL_OP_IGNORE_UNEXPECTED_EOF);
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_num_tickets(context.get(), 0);
  return context;
}

// The TLS machine works on memory; what it wants sent or has to be given goes through the inner link.
class TlsLink : public ByteLink {
 public:
  TlsLink(std::unique_ptr<ByteLink> inner, SSL_CTX* context, TlsSide side)
      : inner_(std::move(inner)), tls_(SSL_new(context)), block_(kBlockBytes) {
    BIO* in = BIO_new(BIO_s_mem());
    out_ = BIO_new(BIO_s_mem());
    TRILAT_CHECK(tls_ && in && out_, "OpenSSL makes a connection");
    BIO_set_mem_eof_return(in, -1);
    SSL_set_bio(tls_.get(), in, out_);
    in_ = in;
    if (side == TlsSide::server) {
      SSL_set_accept_state(tls_.get());
      return;
    }
    SSL_set_connect_state(tls_.get());
    TRILAT_CHECK(SSL_set1_host(tls_.get(), kTlsServerName) == 1, "OpenSSL takes the server's name");
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
    const CertificateHandle peer(SSL_get1_peer_certificate(tls_.get()));
    return peer ? common_name_of(*peer) : std::string();
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
    const long verdict = SSL_get_verify_result(tls_.get());
    const unsigned long code = ERR_peek_last_error();
    const char* text = verdict != X509_V_OK ? X509_verify_cert_error_string(verdict)
                       : code               ? ERR_reason_error_string(code)
                                            : nullptr;
    throw LinkRefused(std::string("TLS: ") + (text ? text : "failed"));
  }

  std::unique_ptr<ByteLink> inner_;
  TlsHandle tls_;
  BIO* in_ = nullptr;  // both belong to tls_
  BIO* out_ = nullptr;
  std::vector<std::byte> block_, unsent_;
  std::size_t unsent_start_ = 0;
};

}  // namespace

TlsIdentity::TlsIdentity(const std::filesystem::path& pem) {
  const PemParts parts = read_parts(pem);
  name_ = common_name_of(*parts.own);
  keys_ = std::make_unique<Keys>(Keys{context_of(parts, TLS_client_method(), pem.string()),
                                      context_of(parts, TLS_server_method(), pem.string())});
}

TlsIdentity::~TlsIdentity() = default;

std::unique_ptr<ByteLink> secure_link(std::unique_ptr<ByteLink> inner, const TlsIdentity& identity,
                                      TlsSide side, std::chrono::milliseconds at_most,
                                      const std::function<bool()>& give_up) {
  const TlsContextHandle& context =
      side == TlsSide::server ? identity.keys().as_server : identity.keys().as_agent;
  auto link = std::make_unique<TlsLink>(std::move(inner), context.get(), side);
  link->handshake(at_most, give_up);
  return link;
}

}  // namespace trilat
