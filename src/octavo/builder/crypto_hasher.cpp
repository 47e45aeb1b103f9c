#include "octavo/builder/crypto_hasher.h"

#include <openssl/evp.h>

#include <new>

#include "octavo/core/error.h"

namespace octavo {

namespace {

template <auto free>
struct Free {
  void operator()(auto* object) const { free(object); }
};
using Method = std::unique_ptr<EVP_MD, Free<EVP_MD_free>>;
using Context = std::unique_ptr<EVP_MD_CTX, Free<EVP_MD_CTX_free>>;

void require_done(int result) {
  if (result != 1) throw Error(ErrorKind::internal, "libcrypto does not compute SHA-256");
}

// Looked for once.
const EVP_MD* sha256_method() {
  static const Method method = [] {
    Method found(EVP_MD_fetch(nullptr, "SHA256", nullptr));
    require_done(found != nullptr ? 1 : 0);
    return found;
  }();
  return method.get();
}

class CryptoHasher final : public Hasher {
 public:
  CryptoHasher() {
    if (context_ == nullptr) throw std::bad_alloc();
    start();
  }

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
  // Of a method that is there only memory can be missing.
  void start() {
    if (EVP_DigestInit_ex(context_.get(), sha256_method(), nullptr) != 1) throw std::bad_alloc();
  }

  Context context_{EVP_MD_CTX_new()};
};

}  // namespace

std::unique_ptr<Hasher> make_crypto_hasher() { return std::make_unique<CryptoHasher>(); }

}  // namespace octavo
