// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: four doubles side by side, one pair of shapes in each lane. Each lane does exactly
// what a plain double would, in the same order.
//
// No include guard: collide_batch.cpp includes this file once for every instruction set, in a namespace each.
// SKERRY_FOUR_AVX2 is 1 where the registers of AVX2 may be used; otherwise a Four is two Twos.

#if SKERRY_FOUR_AVX2

struct Four {
  __m256d v;
  static Four both(double x) { return {_mm256_set1_pd(x)}; }
  /// One number from each place.
  static Four gather(const double* p0, const double* p1, const double* p2, const double* p3) {
    return {_mm256_set_pd(*p3, *p2, *p1, *p0)};
  }
  void store(double* out) const { _mm256_storeu_pd(out, v); }
  /// Whole numbers.
  void store(std::int32_t* out) const {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm256_cvttpd_epi32(v));
  }
};

inline Four chosen(Four mask, Four a, Four b) {
  return {_mm256_blendv_pd(b.v, a.v, mask.v)};
}
inline Four at_least(Four a, Four b) {
  return {_mm256_cmp_pd(a.v, b.v, _CMP_GE_OS)};
}
inline Four below(Four a, Four b) {
  return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OS)};
}
inline unsigned bits(Four mask) {
  return static_cast<unsigned>(_mm256_movemask_pd(mask.v));
}
inline Four operator&(Four a, Four b) {
  return {_mm256_and_pd(a.v, b.v)};
}
inline Four operator|(Four a, Four b) {
  return {_mm256_or_pd(a.v, b.v)};
}
inline Four operator^(Four a, Four b) {
  return {_mm256_xor_pd(a.v, b.v)};
}
inline Four without(Four a, Four mask) {
  return {_mm256_andnot_pd(mask.v, a.v)};
}
inline Four operator+(Four a, Four b) {
  return {_mm256_add_pd(a.v, b.v)};
}
inline Four operator-(Four a, Four b) {
  return {_mm256_sub_pd(a.v, b.v)};
}
inline Four operator*(Four a, Four b) {
  return {_mm256_mul_pd(a.v, b.v)};
}
inline Four operator/(Four a, Four b) {
  return {_mm256_div_pd(a.v, b.v)};
}
inline Four lesser(Four a, Four b) {
  return {_mm256_min_pd(a.v, b.v)};
}
inline Four greater(Four a, Four b) {
  return {_mm256_max_pd(a.v, b.v)};
}
inline Four magnitude(Four a) {
  return {_mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v)};
}
inline Four negated(Four a) {
  return {_mm256_xor_pd(_mm256_set1_pd(-0.0), a.v)};
}
inline Four flipped(Four a, Four mask) {
  return {_mm256_xor_pd(a.v, _mm256_and_pd(_mm256_set1_pd(-0.0), mask.v))};
}
inline Four root(Four a) {
  return {_mm256_sqrt_pd(a.v)};
}
inline Four as_integers(Four a) {
  return {_mm256_castsi256_pd(_mm256_cvtepu32_epi64(_mm256_cvttpd_epi32(a.v)))};
}

/// Four numbers from each of four places: lane k of x, y, z, w is the first to fourth of place k.
struct Columns {
  Four x, y, z, w;
};

inline Columns transposed(__m256d r0, __m256d r1, __m256d r2, __m256d r3) {
  const __m256d xz01 = _mm256_unpacklo_pd(r0, r1), yw01 = _mm256_unpackhi_pd(r0, r1);
  const __m256d xz23 = _mm256_unpacklo_pd(r2, r3), yw23 = _mm256_unpackhi_pd(r2, r3);
  return {{_mm256_permute2f128_pd(xz01, xz23, 0x20)},
          {_mm256_permute2f128_pd(yw01, yw23, 0x20)},
          {_mm256_permute2f128_pd(xz01, xz23, 0x31)},
          {_mm256_permute2f128_pd(yw01, yw23, 0x31)}};
}
inline Columns columns(const double* p0, const double* p1, const double* p2, const double* p3) {
  return transposed(_mm256_loadu_pd(p0), _mm256_loadu_pd(p1), _mm256_loadu_pd(p2), _mm256_loadu_pd(p3));
}
/// The other way round.
inline void store_columns(const Columns& c, double* p0, double* p1, double* p2, double* p3) {
  const Columns rows = transposed(c.x.v, c.y.v, c.z.v, c.w.v);
  _mm256_storeu_pd(p0, rows.x.v);
  _mm256_storeu_pd(p1, rows.y.v);
  _mm256_storeu_pd(p2, rows.z.v);
  _mm256_storeu_pd(p3, rows.w.v);
}

/// Two numbers from each of four places.
struct Points {
  Four x, y;
};

inline Points points(const double* p0, const double* p1, const double* p2, const double* p3) {
  const __m256d even = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(p0)), _mm_loadu_pd(p2), 1);
  const __m256d odd = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(p1)), _mm_loadu_pd(p3), 1);
  return {{_mm256_unpacklo_pd(even, odd)}, {_mm256_unpackhi_pd(even, odd)}};
}
inline void store_points(const Points& p, double* p0, double* p1, double* p2, double* p3) {
  const __m256d even = _mm256_unpacklo_pd(p.x.v, p.y.v), odd = _mm256_unpackhi_pd(p.x.v, p.y.v);
  _mm_storeu_pd(p0, _mm256_castpd256_pd128(even));
  _mm_storeu_pd(p1, _mm256_castpd256_pd128(odd));
  _mm_storeu_pd(p2, _mm256_extractf128_pd(even, 1));
  _mm_storeu_pd(p3, _mm256_extractf128_pd(odd, 1));
}

#else

struct Four {
  Two l, h;
  static Four both(double x) { return {Two::both(x), Two::both(x)}; }
  static Four gather(const double* p0, const double* p1, const double* p2, const double* p3) {
    return {Two::of(*p0, *p1), Two::of(*p2, *p3)};
  }
  void store(double* out) const {
    l.store(out);
    h.store(out + 2);
  }
  void store(std::int32_t* out) const {
    out[0] = static_cast<std::int32_t>(l.low());
    out[1] = static_cast<std::int32_t>(l.high());
    out[2] = static_cast<std::int32_t>(h.low());
    out[3] = static_cast<std::int32_t>(h.high());
  }
};

inline Four chosen(Four mask, Four a, Four b) {
  return {chosen(mask.l, a.l, b.l), chosen(mask.h, a.h, b.h)};
}
inline Four at_least(Four a, Four b) {
  return {at_least(a.l, b.l), at_least(a.h, b.h)};
}
inline Four below(Four a, Four b) {
  return {below(a.l, b.l), below(a.h, b.h)};
}
inline unsigned bits(Four mask) {
  return bits(mask.l) | bits(mask.h) << 2;
}
inline Four operator&(Four a, Four b) {
  return {a.l & b.l, a.h & b.h};
}
inline Four operator|(Four a, Four b) {
  return {a.l | b.l, a.h | b.h};
}
inline Four operator^(Four a, Four b) {
  return {a.l ^ b.l, a.h ^ b.h};
}
inline Four without(Four a, Four mask) {
  return {without(a.l, mask.l), without(a.h, mask.h)};
}
inline Four operator+(Four a, Four b) {
  return {a.l + b.l, a.h + b.h};
}
inline Four operator-(Four a, Four b) {
  return {a.l - b.l, a.h - b.h};
}
inline Four operator*(Four a, Four b) {
  return {a.l * b.l, a.h * b.h};
}
inline Four operator/(Four a, Four b) {
  return {a.l / b.l, a.h / b.h};
}
inline Four lesser(Four a, Four b) {
  return {lesser(a.l, b.l), lesser(a.h, b.h)};
}
inline Four greater(Four a, Four b) {
  return {greater(a.l, b.l), greater(a.h, b.h)};
}
inline Four magnitude(Four a) {
  return {magnitude(a.l), magnitude(a.h)};
}
inline Four negated(Four a) {
  return {negated(a.l), negated(a.h)};
}
inline Four flipped(Four a, Four mask) {
  return {flipped(a.l, mask.l), flipped(a.h, mask.h)};
}
inline Four root(Four a) {
  return {root(a.l), root(a.h)};
}
inline Four as_integers(Four a) {
  return {as_integers(a.l), as_integers(a.h)};
}

struct Columns {
  Four x, y, z, w;
};
struct Points {
  Four x, y;
};

inline Points points(const double* p0, const double* p1, const double* p2, const double* p3) {
  const Two a = Two::load(p0), b = Two::load(p1), c = Two::load(p2), d = Two::load(p3);
  return {{lows(a, b), lows(c, d)}, {highs(a, b), highs(c, d)}};
}
inline void store_points(const Points& p, double* p0, double* p1, double* p2, double* p3) {
  lows(p.x.l, p.y.l).store(p0);
  highs(p.x.l, p.y.l).store(p1);
  lows(p.x.h, p.y.h).store(p2);
  highs(p.x.h, p.y.h).store(p3);
}
inline Columns columns(const double* p0, const double* p1, const double* p2, const double* p3) {
  const Points front = points(p0, p1, p2, p3), back = points(p0 + 2, p1 + 2, p2 + 2, p3 + 2);
  return {front.x, front.y, back.x, back.y};
}
inline void store_columns(const Columns& c, double* p0, double* p1, double* p2, double* p3) {
  store_points({c.x, c.y}, p0, p1, p2, p3);
  store_points({c.z, c.w}, p0 + 2, p1 + 2, p2 + 2, p3 + 2);
}

#endif
