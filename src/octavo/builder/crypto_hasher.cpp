#include "octavo/builder/crypto_hasher.h"

#include <openssl/evp.h>

#include "octavo/core/error.h"

namespace octavo {

namespace {

void require_done(int result) {
  if (result != 1) throw Error(ErrorKind::internal, "libcrypto does not compute SHA-256");
}

class CryptoHasher final : public Hasher {
 public:
  CryptoHasher() { start(); }

  void add(ByteSpan bytes) override {
    require_done(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
  }

  Sha256Digest digest() override {
    Sha256Digest result{};
    require_done(EVP_DigestFinal_ex(context_.get(), result.data(), nullptr));
    start();
    return result;
  }

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };

  void start() { require_done(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr)); }

  std::unique_ptr<EVP_MD_CTX, Free> context_{EVP_MD_CTX_new()};
};

}  // namespace

std::unique_ptr<Hasher> make_crypto_hasher() { return std::make_unique<CryptoHasher>(); }

}  // namespace octavo
