// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

namespace trilat {

template <auto release>
struct OpensslRelease {
  template <class T>
  void operator()(T* handle) const {
    release(handle);
  }
};

using BioHandle = std::unique_ptr<BIO, OpensslRelease<BIO_free_all>>;
using KeyHandle = std::unique_ptr<EVP_PKEY, OpensslRelease<EVP_PKEY_free>>;
using CertificateHandle = std::unique_ptr<X509, OpensslRelease<X509_free>>;
using TlsContextHandle = std::unique_ptr<SSL_CTX, OpensslRelease<SSL_CTX_free>>;
using TlsHandle = std::unique_ptr<SSL, OpensslRelease<SSL_free>>;

// The name in the certificate's subject; empty where there is none.
inline std::string common_name_of(const X509& certificate) {
  char name[128] = "";
  X509_NAME_get_text_by_NID(X509_get_subject_name(&certificate), NID_commonName, name, sizeof name);
  return name;
}

}  // namespace trilat
