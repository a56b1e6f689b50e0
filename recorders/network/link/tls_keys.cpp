// SPDX-License-Identifier: MIT
#include "recorders/network/link/tls_keys.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>

#include <fcntl.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "recorders/network/link/openssl_handles.h"
#include "recorders/network/link/tls_link.h"
#include "recorders/network/link/wire.h"

namespace trilat {
namespace {

constexpr long kValidDays = 20 * 365;
constexpr long kSecondsADay = 86400;
constexpr long kBackdatedDays = 2;  // the clocks of sensor PCs are not always right

struct KeyPair {
  KeyHandle key;
  CertificateHandle certificate;
};

struct CertificateKind {
  std::string name;
  const char* basic_constraints;
  const char* key_usage;
  const char* extended_usage;  // null: none
};

void add_extension(X509* certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
  TRILAT_CHECK(extension && X509_add_ext(certificate, extension, -1) == 1, "OpenSSL adds an extension");
  X509_EXTENSION_free(extension);
}

void set_serial(X509* certificate) {
  unsigned char bytes[16];
  TRILAT_CHECK(RAND_bytes(bytes, sizeof bytes) == 1, "OpenSSL has random bytes");
  bytes[0] &= 0x7f;
  BIGNUM* number = BN_bin2bn(bytes, sizeof bytes, nullptr);
  TRILAT_CHECK(number && BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate)),
               "OpenSSL takes a serial number");
  BN_free(number);
}

// Signed by `authority`, or by itself where there is none.
KeyPair make_pair(const CertificateKind& kind, const KeyPair* authority) {
  KeyPair pair{KeyHandle(EVP_EC_gen("P-256")), CertificateHandle(X509_new())};
  X509* certificate = pair.certificate.get();
  TRILAT_CHECK(pair.key && certificate, "OpenSSL makes a key");
  X509* issuer = authority ? authority->certificate.get() : certificate;
  X509_set_version(certificate, X509_VERSION_3);
  set_serial(certificate);
  X509_gmtime_adj(X509_getm_notBefore(certificate), -kBackdatedDays * kSecondsADay);
  X509_gmtime_adj(X509_getm_notAfter(certificate), kValidDays * kSecondsADay);
  X509_set_pubkey(certificate, pair.key.get());
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(kind.name.c_str()), -1, -1, 0);
  X509_set_issuer_name(certificate, X509_get_subject_name(issuer));
  add_extension(certificate, issuer, NID_basic_constraints, kind.basic_constraints);
  add_extension(certificate, issuer, NID_key_usage, kind.key_usage);
  if (kind.extended_usage) {
    add_extension(certificate, issuer, NID_ext_key_usage, kind.extended_usage);
    add_extension(certificate, issuer, NID_subject_alt_name, ("DNS:" + kind.name).c_str());
  }
  EVP_PKEY* signer = authority ? authority->key.get() : pair.key.get();
  TRILAT_CHECK(X509_sign(certificate, signer, EVP_sha256()) > 0, "OpenSSL signs");
  return pair;
}

std::string pem_text(const KeyPair& pair, const KeyPair* authority) {
  const BioHandle bio(BIO_new(BIO_s_mem()));
  bool written =
      PEM_write_bio_PrivateKey(bio.get(), pair.key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1 &&
      PEM_write_bio_X509(bio.get(), pair.certificate.get()) == 1;
  if (authority) written = written && PEM_write_bio_X509(bio.get(), authority->certificate.get()) == 1;
  TRILAT_CHECK(written, "OpenSSL writes PEM into memory");
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

void write_secret(const std::filesystem::path& path, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0) throw OutputError(path.string(), std::string("cannot be made: ") + std::strerror(errno));
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const bool closed = ::fsync(fd) == 0 && ::close(fd) == 0;
  if (written && closed) return;
  ::unlink(path.c_str());
  throw OutputError(path.string(), "cannot be written to its end");
}

KeyPair read_authority(const std::filesystem::path& path) {
  const std::string text = read_file(path, 1u << 16);
  const BioHandle bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
  KeyPair pair;
  pair.key.reset(PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, const_cast<char*>("")));
  pair.certificate.reset(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (!pair.key || !pair.certificate || X509_check_private_key(pair.certificate.get(), pair.key.get()) != 1)
    throw InputError(path.string(), "must hold the authority's private key and its certificate");
  return pair;
}

void check_names(const std::filesystem::path& folder, const std::vector<std::string>& agents) {
  std::set<std::string> seen{"ca", "server"};
  for (const std::string& name : agents) {
    const bool plain = std::ranges::all_of(name, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
             c == '_';
    });
    if (name.empty() || name.size() > kMaxNameBytes || !plain)
      throw InputError('"' + name + '"', "is no name of an agent: 1 to 64 letters, digits, - and _");
    if (!seen.insert(name).second)
      throw InputError('"' + name + '"', "is taken: each agent needs a name of its own, not ca or server");
    if (std::filesystem::exists(folder / (name + ".pem")))
      throw InputError((folder / (name + ".pem")).string(), "exists already and is not overwritten");
  }
}

}  // namespace

std::vector<std::filesystem::path> make_tls_keys(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& agents) {
  check_names(folder, agents);
  make_folder(folder);
  std::vector<std::filesystem::path> made;
  const auto write = [&](const char* stem, const KeyPair& pair, const KeyPair* authority) {
    made.push_back(folder / (std::string(stem) + ".pem"));
    write_secret(made.back(), pem_text(pair, authority));
  };
  KeyPair authority;
  if (std::filesystem::exists(folder / "ca.pem")) {
    authority = read_authority(folder / "ca.pem");
  } else {
    if (std::filesystem::exists(folder / "server.pem"))
      throw InputError((folder / "ca.pem").string(), "is missing, though server.pem is there");
    authority = make_pair({"trilat authority", "critical,CA:TRUE", "critical,keyCertSign", nullptr}, nullptr);
    write("ca", authority, nullptr);
  }
  const auto signed_pair = [&](const std::string& name, const char* usage) {
    return make_pair({name, "critical,CA:FALSE", "critical,digitalSignature", usage}, &authority);
  };
  if (!std::filesystem::exists(folder / "server.pem"))
    write("server", signed_pair(kTlsServerName, "serverAuth"), &authority);
  for (const std::string& name : agents) write(name.c_str(), signed_pair(name, "clientAuth"), &authority);
  return made;
}

}  // namespace trilat
