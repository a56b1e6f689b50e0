// SPDX-License-Identifier: MIT
// Random numbers for a vector of counters at once, the same as RandomStream's. Included once for each
// instruction set, behind hwy/foreach_target.h.
#if defined(TRILAT_RANDOM_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRILAT_RANDOM_LANES_INL_H_
#undef TRILAT_RANDOM_LANES_INL_H_
#else
#define TRILAT_RANDOM_LANES_INL_H_
#endif

#include <cstdint>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using U = hn::RebindToUnsigned<D>;
using Doubles = hn::Vec<D>;
using Bits = hn::Vec<U>;

// The product of the low 32 bits of each lane and a constant.
HWY_INLINE Bits TimesLow32(Bits a, std::uint32_t factor) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Set(U(), (hn::GetLane(a) & 0xFFFFFFFFu) * std::uint64_t{factor});
#else
  const hn::RepartitionToNarrow<U> narrow;
  return hn::MulEven(hn::BitCast(narrow, a), hn::Set(narrow, factor));
#endif
}

// Philox4x32-10 in place, one counter of four words a lane. Only the low 32 bits of each word count, before
// and after.
HWY_INLINE void Philox(std::uint64_t seed, Bits& c0, Bits& c1, Bits& c2, Bits& c3) {
  const U u;
  auto k0 = static_cast<std::uint32_t>(seed);
  auto k1 = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < 10; ++round) {
    const Bits a = TimesLow32(c0, 0xD2511F53);
    const Bits b = TimesLow32(c2, 0xCD9E8D57);
    c0 = hn::Xor(hn::Xor(hn::ShiftRight<32>(b), c1), hn::Set(u, std::uint64_t{k0}));
    c2 = hn::Xor(hn::Xor(hn::ShiftRight<32>(a), c3), hn::Set(u, std::uint64_t{k1}));
    c1 = b;
    c3 = a;
    k0 += 0x9E3779B9;
    k1 += 0xBB67AE85;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#endif
