// SPDX-License-Identifier: MIT
// One source, compiled once for each instruction set. Nothing is fused, functions are polynomials of our own
// and nothing but a minimum is taken across lanes: so every set and every width gives the same bits.
#include "datasets/synthetic/depth/depth_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numbers>

// SSE2 is there on every x86-64; these bring nothing beyond SSE4 and AVX-512 here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "datasets/synthetic/depth/depth_kernel.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include "datasets/synthetic/depth/depth_cast-inl.h"
#include "datasets/synthetic/depth/depth_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {

float CastImage(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes, const float* ray_x,
                const float* ray_y, float* depth_m) {
  const F f;
  std::vector<float> cosine(layout.stride());
  Floats least = Single(std::numeric_limits<float>::infinity());
  for (int r = 0; r < layout.height_px; ++r) {
    const RayRow row{ray_x + layout.row(r), ray_y + layout.row(r), depth_m + layout.row(r), cosine.data()};
    CastRow(view, boxes, r, layout.width_px, row);
    for (int column = 0; column < layout.width_px; column += static_cast<int>(hn::Lanes(f)))
      least = hn::Min(least, hn::LoadU(f, row.depth_m + column));
  }
  return hn::GetLane(hn::MinOfLanes(f, least));
}

// The jittered rays of one row, their axial noise (standard normal) and what they meet.
struct NoisyRow {
  std::vector<float> x, y, normal, depth_m, cosine;
  std::vector<std::uint16_t> depth_mm;
  explicit NoisyRow(std::size_t n)
      : x(n, std::numeric_limits<float>::quiet_NaN()), y(x), normal(n), depth_m(n), cosine(n), depth_mm(n) {}
};

struct RowInputs {
  const float* ray_x;
  const float* ray_y;
  const float* noise_factor;
  const float* exact_m;
  std::size_t stride;
  std::uint32_t first_pixel;
  int columns;
};

void JitterRow(const RowInputs& in, const DepthNoiseNumbers& noise, const RandomStream& key, NoisyRow& row) {
  const F f;
  for (int column = 0; column < in.columns; column += static_cast<int>(hn::Lanes(f))) {
    const auto words = BlocksOf(key, in.first_pixel + static_cast<std::uint32_t>(column));
    Floats right, up, axial, unused;
    NormalsOf(words.w0, words.w1, right, up);
    NormalsOf(words.w2, words.w3, axial, unused);
    const Floats exact = hn::LoadU(f, in.exact_m + column), nearest = Single(noise.nearest_m);
    const Floats scale = Single(noise.lateral_sigma_m) / hn::IfThenElse(exact < nearest, nearest, exact);
    hn::StoreU(hn::LoadU(f, in.ray_x + column) + scale * right, f, &row.x[static_cast<std::size_t>(column)]);
    hn::StoreU(hn::LoadU(f, in.ray_y + column) + scale * up, f, &row.y[static_cast<std::size_t>(column)]);
    hn::StoreU(axial, f, &row.normal[static_cast<std::size_t>(column)]);
  }
}

// At an edge most pixels are lost (made infinite); the others lie anywhere between the two surfaces, when
// there are two.
HWY_INLINE Floats MixedAtEdges(const RowInputs& in, int column, const DepthNoiseNumbers& noise,
                               const RandomStream& key, Floats depth) {
  const F f;
  const float* exact_m = in.exact_m + column;
  const Floats exact = hn::LoadU(f, exact_m);
  Floats step = hn::Zero(f), other = exact;
  for (const float* neighbour : {exact_m - 1, exact_m + 1, exact_m - in.stride, exact_m + in.stride}) {
    const Floats there = hn::LoadU(f, neighbour);
    const Floats by = hn::Abs(there - exact);
    other = hn::IfThenElse(by > step, there, other);
    step = hn::IfThenElse(by > step, by, step);
  }
  const auto edge = step > Single(noise.edge_step_m);
  if (hn::AllFalse(f, edge)) return depth;
  const auto words = BlocksOf(key, kEdgeIndex + in.first_pixel + static_cast<std::uint32_t>(column));
  const Floats nothing = Single(std::numeric_limits<float>::infinity());
  const Floats between = depth + UnitOf(words.w1) * (other - depth);
  const Floats kept = hn::IfThenElse(other < nothing, between, depth);
  const auto dropped = UnitOf(words.w0) < Single(noise.edge_dropped_share);
  return hn::IfThenElse(edge, hn::IfThenElse(dropped, nothing, kept), depth);
}

HWY_INLINE Floats SigmaOf(const DepthNoiseNumbers& noise, Floats depth, Floats cosine) {
  const Floats angle = ArcCosine(hn::IfThenElse(cosine < Single(1.0f), cosine, Single(1.0f)));
  const Floats rest = Single(std::numbers::pi_v<float> / 2.0f) - angle;
  const Floats share = angle / hn::IfThenElse(rest > Single(1e-3f), rest, Single(1e-3f));
  return Single(noise.level_m) + depth * (Single(noise.slope) + depth * Single(noise.square_per_m)) +
         Single(noise.angle) * depth * hn::Sqrt(depth) * share * share;
}

HWY_INLINE Floats BiasOf(const DepthNoiseNumbers& noise, Floats depth) {
  const Floats turns = depth * Single(noise.wiggle_per_m) + Single(noise.wiggle_turn);
  Floats sine, cosine;
  SingleSineCosine(turns - hn::Floor(turns), sine, cosine);
  return Single(noise.offset_m) + Single(noise.wiggle_amplitude_m) * sine;
}

void MeasureRow(const RowInputs& in, const DepthNoiseNumbers& noise, const RandomStream& key, NoisyRow& row) {
  const F f;
  const Floats nothing = Single(std::numeric_limits<float>::infinity());
  for (int column = 0; column < in.columns; column += static_cast<int>(hn::Lanes(f))) {
    const auto at = static_cast<std::size_t>(column);
    const Floats cosine = hn::LoadU(f, &row.cosine[at]);
    const Floats factor = hn::LoadU(f, in.noise_factor + column);
    const Floats met = MixedAtEdges(in, column, noise, key, hn::LoadU(f, &row.depth_m[at]));
    const auto seen =
        hn::And(hn::And(met < nothing, factor >= hn::Zero(f)), cosine >= Single(noise.least_cosine));
    const Floats depth = hn::IfThenElse(seen, met, Single(1.0f));
    const Floats measured =
        depth + BiasOf(noise, depth) + SigmaOf(noise, depth, cosine) * factor * hn::LoadU(f, &row.normal[at]);
    const auto valid =
        hn::And(seen, hn::And(measured >= Single(noise.nearest_m), measured <= Single(noise.farthest_m)));
    const auto rounded = hn::NearestInt(hn::IfThenElseZero(valid, measured * Single(1000.0f)));
    hn::StoreU(hn::DemoteTo(hn::Rebind<std::uint16_t, I32>(), rounded), hn::Rebind<std::uint16_t, I32>(),
               &row.depth_mm[at]);
  }
}

void RenderImage(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes,
                 const DepthNoiseNumbers& noise, const RandomStream& key, const float* ray_x,
                 const float* ray_y, const float* noise_factor, const float* exact_m,
                 std::uint16_t* depth_mm) {
  NoisyRow noisy(layout.stride());
  const auto width = static_cast<std::size_t>(layout.width_px);
  for (int r = 0; r < layout.height_px; ++r) {
    const std::size_t at = layout.row(r), first_pixel = static_cast<std::size_t>(r) * width;
    const RowInputs in{ray_x + at,     ray_y + at,      noise_factor + at,
                       exact_m + at,   layout.stride(), static_cast<std::uint32_t>(first_pixel),
                       layout.width_px};
    JitterRow(in, noise, key, noisy);
    CastRow(view, boxes, r, layout.width_px,
            {noisy.x.data(), noisy.y.data(), noisy.depth_m.data(), noisy.cosine.data()});
    MeasureRow(in, noise, key, noisy);
    std::memcpy(depth_mm + first_pixel, noisy.depth_mm.data(), width * sizeof(std::uint16_t));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trilat {
HWY_EXPORT(CastImage);
HWY_EXPORT(RenderImage);

float cast_depth(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes, const float* ray_x,
                 const float* ray_y, float* depth_m) {
  return HWY_DYNAMIC_DISPATCH(CastImage)(layout, view, boxes, ray_x, ray_y, depth_m);
}

void render_depth(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes,
                  const DepthNoiseNumbers& noise, const RandomStream& frame_key, const float* ray_x,
                  const float* ray_y, const float* noise_factor, const float* exact_m,
                  std::uint16_t* depth_mm) {
  HWY_DYNAMIC_DISPATCH(RenderImage)
  (layout, view, boxes, noise, frame_key, ray_x, ray_y, noise_factor, exact_m, depth_mm);
}

}  // namespace trilat
#endif  // HWY_ONCE
