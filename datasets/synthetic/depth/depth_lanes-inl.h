// SPDX-License-Identifier: MIT
// Single-precision functions of a vector, exact to a few units in the last place: sums and products are
// written out and never fused, so that every instruction set gives the same bits. Included once for each
// instruction set, behind hwy/foreach_target.h.
#if defined(TRILAT_DEPTH_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRILAT_DEPTH_LANES_INL_H_
#undef TRILAT_DEPTH_LANES_INL_H_
#else
#define TRILAT_DEPTH_LANES_INL_H_
#endif

#include <cstdint>
#include <numbers>

#include <hwy/highway.h>

#include "datasets/base/philox.h"
#include "datasets/synthetic/depth/random_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {

using F = hn::ScalableTag<float>;
using I32 = hn::RebindToSigned<F>;
using U32 = hn::RebindToUnsigned<F>;
using Floats = hn::Vec<F>;
using Words = hn::Vec<U32>;

HWY_INLINE Floats Single(float value) { return hn::Set(F(), value); }

struct FourWords {
  Words w0, w1, w2, w3;
};

// The blocks of indices first, first + 1, … of a stream: one index a lane.
HWY_INLINE FourWords BlocksOf(const RandomStream& stream, std::uint32_t first) {
  const U u;
  const Bits even = hn::Add(hn::Set(u, std::uint64_t{first}), hn::ShiftLeft<1>(hn::Iota(u, 0)));
  Bits words[2][4];
  for (std::uint64_t odd : {0u, 1u}) {
    Bits(&c)[4] = words[odd];
    c[0] = hn::Add(even, hn::Set(u, odd));
    c[1] = hn::Set(u, stream.item);
    c[2] = hn::Set(u, stream.item >> 32);
    c[3] = hn::Set(u, static_cast<std::uint64_t>(stream.purpose));
    Philox(stream.seed, c[0], c[1], c[2], c[3]);
  }
  const auto joined = [&](int i) {
    const Bits low = hn::And(words[0][i], hn::Set(u, std::uint64_t{0xFFFFFFFF}));
    return hn::BitCast(U32(), hn::Or(low, hn::ShiftLeft<32>(words[1][i])));
  };
  return {joined(0), joined(1), joined(2), joined(3)};
}

// In (0, 1), 23 bits and a half.
HWY_INLINE Floats UnitOf(Words word) {
  const Floats bits = hn::ConvertTo(F(), hn::BitCast(I32(), hn::ShiftRight<9>(word)));
  return (bits + Single(0.5f)) * Single(0x1p-23f);
}

// Horner's rule, the highest power first.
template <std::size_t n>
HWY_INLINE Floats SinglePolynomial(Floats x, const float (&coefficient)[n]) {
  Floats sum = Single(coefficient[0]);
  for (std::size_t i = 1; i < n; ++i) sum = sum * x + Single(coefficient[i]);
  return sum;
}

// Sine and cosine of `turn` times 2 pi, turn in [0, 1].
HWY_INLINE void SingleSineCosine(Floats turn, Floats& sine, Floats& cosine) {
  static constexpr float kSine[] = {1.0f / 362880.0f, -1.0f / 5040.0f, 1.0f / 120.0f, -1.0f / 6.0f, 1.0f};
  static constexpr float kCosine[] = {1.0f / 40320.0f, -1.0f / 720.0f, 1.0f / 24.0f, -0.5f, 1.0f};
  const Floats quarters = turn * Single(4.0f);
  const Floats nearest = hn::Round(quarters);
  const Floats angle = (quarters - nearest) * Single(std::numbers::pi_v<float> / 2.0f);
  const Floats square = angle * angle;
  const Floats s = angle * SinglePolynomial(square, kSine);
  const Floats c = SinglePolynomial(square, kCosine);
  const auto odd = hn::Or(nearest == Single(1.0f), nearest == Single(3.0f));
  const Floats first = hn::IfThenElse(odd, c, s);
  const Floats second = hn::IfThenElse(odd, s, c);
  const auto lower_half = hn::And(nearest > Single(1.5f), nearest < Single(3.5f));
  const auto left_half = hn::And(nearest > Single(0.5f), nearest < Single(2.5f));
  sine = hn::IfThenElse(lower_half, hn::Neg(first), first);
  cosine = hn::IfThenElse(left_half, hn::Neg(second), second);
}

// Natural logarithm of numbers in (0, 1): 2 atanh((m - 1) / (m + 1)) of the mantissa m in [2/3, 4/3).
HWY_INLINE Floats SingleLogarithm(Floats x) {
  static constexpr float kAtanh[] = {1.0f / 9.0f, 1.0f / 7.0f, 1.0f / 5.0f, 1.0f / 3.0f, 1.0f};
  const I32 i;
  const auto bits = hn::BitCast(i, x);
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(i, 0x3F2AAAAB)));  // of 2/3
  const Floats m = hn::BitCast(F(), hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const Floats s = (m - Single(1.0f)) / (m + Single(1.0f));
  const Floats series = s * SinglePolynomial(s * s, kAtanh);
  return series + series + hn::ConvertTo(F(), exponent) * Single(std::numbers::ln2_v<float>);
}

// Two independent standard normals from two words (Box and Muller).
HWY_INLINE void NormalsOf(Words a, Words b, Floats& first, Floats& second) {
  Floats sine, cosine;
  SingleSineCosine(UnitOf(b), sine, cosine);
  const Floats radius = hn::Sqrt(Single(-2.0f) * SingleLogarithm(UnitOf(a)));
  first = radius * cosine;
  second = radius * sine;
}

// Arc cosine of numbers in [0, 1], within 2e-8 (Abramowitz and Stegun 4.4.46).
HWY_INLINE Floats ArcCosine(Floats x) {
  static constexpr float kArcCosine[] = {-0.0012624911f, 0.0066700901f, -0.0170881256f, 0.0308918810f,
                                         -0.0501743046f, 0.0889789874f, -0.2145988016f, 1.5707963050f};
  return hn::Sqrt(Single(1.0f) - x) * SinglePolynomial(x, kArcCosine);
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#endif
